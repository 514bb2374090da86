"""Ends a tool: prints an error as one line on stderr, never a traceback."""

import argparse
import os
import sys

CANNOT = 2  # exit code


class Parser(argparse.ArgumentParser):
    """A parser whose complaint is one line; -h lists the options."""

    def error(self, message):
        self.exit(CANNOT, f"{self.prog}: {message}; {self.prog} -h says more\n")


def command(main):
    """Exit code of main(), also where it has left by sys.exit(). Errors that speak for themselves (OSError, the tools' own kinds of ValueError) become one line and exit code 2; a
    reader that has seen enough (`| head`) ends the tool without a word."""
    try:
        try:
            code = main()
        except SystemExit as end:
            code = end.code
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nothing more is said when Python ends
        return 0
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        return print_error(words_of(error))
    except ValueError as error:
        if type(error) is ValueError:
            raise  # a fault of the tool: its trace says where
        return print_error(str(error))
    return code


def words_of(error):
    """Returns the text of an error; for a file its name and the reason."""
    if not isinstance(error, OSError):
        return str(error)
    return f"{error.filename}: {error.strerror or error}" if error.filename else str(error.strerror or error)


def print_error(message):
    name = os.path.splitext(os.path.basename(sys.argv[0]))[0]
    print(f"{name}: {' '.join(message.split())}", file=sys.stderr)
    return CANNOT
