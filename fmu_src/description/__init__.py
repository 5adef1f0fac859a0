"""What an FMU says of itself: variables, XML, documentation, icon, expected results."""
