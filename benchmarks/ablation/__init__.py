"""What each stage of selection and refinement is worth on random records."""
