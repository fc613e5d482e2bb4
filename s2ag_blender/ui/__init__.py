"""All that is drawn or pressed."""
