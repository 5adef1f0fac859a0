"""What a script does with a user's mistake."""

import pytest

from gtm_fmu.errors import InputError, script


def test_bad_input_is_a_sentence_and_code_2(capsys):
    @script
    def main():
        raise InputError("There is no folder 'x': make it.")

    assert main() == 2
    assert capsys.readouterr() == ("", "There is no folder 'x': make it.\n")


def test_without_a_mistake_the_code_is_0():
    assert script(lambda: None)() == 0


def test_faults_of_the_program_are_not_hidden():
    @script
    def main():
        raise ValueError("a fault of ours")

    with pytest.raises(ValueError, match="a fault of ours"):
        main()
