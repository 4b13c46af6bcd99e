"""Tables, each built once as a model, and shown in a terminal or in Markdown; ``publishing`` shows them in HTML."""
