"""The paper's study with people: its plan, what each participant answered, and what that shows."""
