"""A number as it is printed, which knows its value in full: for a spreadsheet."""


class Figure(str):
    value: float

    def __new__(cls, text, value):
        made = super().__new__(cls, text)
        made.value = float(value)
        return made
