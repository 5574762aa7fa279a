"""The paper's study: the mine ride rendered in four ways, what tells them apart as numbers, and a report of it."""
