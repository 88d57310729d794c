"""What all stages share: the recipe, messages, random numbers, arrays."""
