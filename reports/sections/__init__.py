"""Content of each section of the report, built from the results of the other rooms."""
