"""The directed performance corpus: captured gesture clips placed on speech."""
