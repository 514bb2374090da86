"""Prints a number and keeps its full value: for a spreadsheet."""


class Figure(str):
    value: float

    def __new__(cls, text, value):
        made = super().__new__(cls, text)
        made.value = float(value)
        return made
