"""What a checkpoint's network listens to: figures of ``s2ag evaluate --listens``, each a function of its own."""
