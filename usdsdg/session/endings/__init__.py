"""What ends a command before its work is done: a signal, the end of the parent process, or an error."""
