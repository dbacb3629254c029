"""Changes of model files, in their bytes."""

import re


def renamed(content):
    """The model file under the name of another training run; also that of before and the new one.

    Protocol buffers keep a text as its length and its bytes, so a name of the same length may stand in its place.
    """
    key = content.index(b'run_id') + len(b'run_id')
    length = content[key + 1]  # after the field's tag
    begin = key + 2
    name = content[begin:begin + length]
    assert re.fullmatch(rb'[\w.:-]+', name), name
    other = name[:-1] + (b'0' if name[-1:] != b'0' else b'1')
    return content[:begin] + other + content[begin + length:], name.decode(), other.decode()
