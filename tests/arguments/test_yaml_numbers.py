"""What the values of YAML files are: those of YAML 1.2, or an error of YAML."""

import pytest
import yaml

from usdsdg.arguments.yaml_numbers import NumbersLoader


@pytest.mark.parametrize("text", ["2020-01-31", "2020-13-45", "2001-12-14 21:59:43.10"])
def test_dates_are_text_as_in_yaml_1_2(text):
    """A class may be called so; PyYAML makes a date of it, or raises a ValueError."""
    assert yaml.load(f"label: {text}", Loader=NumbersLoader) == {"label": text}
    assert not isinstance(yaml.safe_load("label: 2020-01-31")["label"], str), "PyYAML's own loader is as it was"


@pytest.mark.parametrize("value", ['!!int ""', "!!int x", '!!float ""', "!!bool perhaps", "!!timestamp x"])
def test_a_value_that_its_tag_does_not_fit_is_an_error_of_yaml(value):
    with pytest.raises(yaml.MarkedYAMLError, match="is no ") as refused:
        yaml.load(f"a: 1\nb: {value}", Loader=NumbersLoader)
    assert refused.value.problem_mark.line == 1
