"""What a selection is written as: lists, and captures that trainers read."""
