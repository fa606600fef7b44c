from retarget.solve.filter import Filter


def test_takes_what_is_cheaper_or_violates_less():
    tried = Filter(10)
    tried.add(5.0, 1e-3)
    assert tried.accepts(4.0, 5e-3)
    assert tried.accepts(6.0, 1e-4)
    assert not tried.accepts(5.5, 1e-3)


def test_remembers_every_point():
    tried = Filter(10)
    tried.add(5.0, 1e-3)
    tried.add(4.0, 5e-3)
    assert not tried.accepts(5.5, 2e-3)
    assert not tried.accepts(4.5, 6e-3)
    assert tried.accepts(4.5, 2e-3)


def test_no_gain_pays_for_a_large_violation():
    tried = Filter(10)
    tried.add(5.0, 1e-3)
    assert not tried.accepts(0.0, 0.1)
