"""What editors ask about programs that are being written; `service` names it all."""
