"""A simulated run as its user meets it: series by name, numbers, a result with tables and charts."""
