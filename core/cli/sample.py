"""placeholder"""
SUMMARY = "x"
EXAMPLE = "x"
def configure(parser): pass
def run(options): return 0
