"""What cannot be simulated, and why."""


class Unfit(Exception):
    """An object or a setting that does not do. The text names it, and says what to do."""
