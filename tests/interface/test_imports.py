"""No module imports itself by way of others, not even inside a function or for types alone."""

import grimp
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def circles(imports):
    """Return the sets of modules that import each other, from what each imports."""
    modules = sorted(imports)
    index = {name: number for number, name in enumerate(modules)}
    edges = [(index[one], index[other]) for one in modules for other in imports[one]]
    rows, columns = np.array(edges).T
    graph = coo_array((np.ones(len(edges)), (rows, columns)), shape=(len(modules),) * 2)
    labels = connected_components(graph.tocsr(), connection="strong")[1]
    groups = [set(np.array(modules)[labels == label].tolist()) for label in np.unique(labels)]
    return [group for group in groups if len(group) > 1]


def test_circles_are_found():
    imports = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set()}
    assert circles(imports) == [{"b", "c"}]


def test_no_import_circles():
    graph = grimp.build_graph("slipfold", cache_dir=None)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    assert circles(imports) == []
