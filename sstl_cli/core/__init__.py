"""Tables, files, configuration, units, random numbers and errors: what every layer stands on."""
