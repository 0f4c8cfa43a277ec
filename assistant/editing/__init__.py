"""Answers for editors about programs during typing; `service` names all of them."""
