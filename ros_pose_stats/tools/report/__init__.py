"""The report on a part: one page to look at, to print and to send to a colleague."""
