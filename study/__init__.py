"""The paper's study: the mine ride rendered in four modes, measures of their differences, and a
report."""
