"""Files that a command will write, checked before it computes anything."""

from skinfield.errors import InputError


def check_output(flag: str, name: str | None, ending: str) -> None:
    """Raise InputError unless `name`, where there is one, has the ending and can be written.

    Parameters
    ----------
    flag : str
        As the user gave it, such as "--csv".
    name : str or None
        Of the file.
    ending : str
        Such as ".csv".
    """
    from skinfield.sinks.pending import pending

    if name is None:
        return
    if not name.lower().endswith(ending):
        raise InputError(f"{flag} is {name!r}, expected a name that ends in {ending}")
    pending(name)  # makes nothing: it says what is wrong with the folder
