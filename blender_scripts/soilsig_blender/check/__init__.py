"""Whether a settled bed is to be trusted, how deep it is and how much of it is void."""
