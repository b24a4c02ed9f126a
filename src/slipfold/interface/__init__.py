"""What users see: the command line, the page in the browser, and the reproduction of the paper."""
