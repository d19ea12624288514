"""What a user would write instead: one peer a file, none of it calls the product."""
