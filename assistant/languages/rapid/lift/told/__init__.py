"""What other languages are told in the place of instructions that RAPID alone has."""
