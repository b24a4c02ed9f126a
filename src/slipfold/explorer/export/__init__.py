"""What is shown, as a file or as the text that makes it."""
