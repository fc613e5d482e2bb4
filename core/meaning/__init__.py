"""What words mean to the body: phrases that have a gesture of their own, and how it is shown."""
