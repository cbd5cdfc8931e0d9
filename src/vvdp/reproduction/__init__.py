"""The dissertation of wang2017, item by item: every figure, table and claimed number beside vvdp's own."""
