"""Cases that any program can run, their reference tables, and the script that scores a program."""
