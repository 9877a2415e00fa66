"""What each section of the report prints, gathered from the objects of the other rooms."""
