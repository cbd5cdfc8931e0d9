"""A system as one page that runs it in a browser: the compiled model as WebAssembly, its values, charts and diagram."""
