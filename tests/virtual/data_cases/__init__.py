"""Programs of RAPID by subject, each with what its moves show: `SHOW a,b,c DONE`."""
