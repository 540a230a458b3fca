"""Parts of the command ``plica``: what each says, asks for and does."""
