"""What places are there and how do they join? Free space, gateways, regions, classes, objects."""
