"""The `s2ag` command line."""
