"""Whatever is sent to the HTTP interface, the server does not fail."""

import hypothesis
import pytest
import schemathesis
from hypothesis import strategies as st
from schemathesis.checks import not_a_server_error

from helpers.explorer_server import PATIENCE, diagram


@pytest.fixture(scope="module")
def schema(explorer):
    return schemathesis.openapi.from_url(
        f"{explorer.base}/openapi.json", headers={"cookie": explorer.cookie}
    )


@pytest.mark.parametrize(
    "operation",
    [
        ("/api/models", "GET"),
        ("/api/export", "POST"),
        ("/api/measurements", "POST"),
        ("/api/model", "POST"),
        ("/api/text", "POST"),
        ("/api/law", "POST"),
    ],
    ids=str,
)
def test_no_request_that_the_schema_describes_makes_the_server_fail(explorer, schema, operation):
    path, method = operation

    @hypothesis.settings(max_examples=40)
    @hypothesis.given(case=schema[path][method].as_strategy())
    def send(case):
        answer = case.call(
            base_url=explorer.base, headers={"cookie": explorer.cookie}, timeout=PATIENCE
        )
        case.validate_response(answer, checks=[not_a_server_error])

    send()


def test_no_body_at_all_makes_the_server_fail(explorer):
    with explorer.http() as http:

        @hypothesis.given(st.binary(max_size=200))
        def send(body):
            answer = http.post("/api/export", content=body)
            assert answer.status_code == 422

        send()


def test_values_that_no_orbit_can_have_make_nothing_fail(client):
    numbers = st.floats(-1e12, 1e12) | st.sampled_from([0.0, 1e-300, 5e-324, -1e12])
    names = st.sampled_from(["f", "Nd", "Ns", "mu", "Vd", "alpha", "L", "k1", "kext"])

    @hypothesis.settings(max_examples=15)
    @hypothesis.given(st.dictionaries(names, numbers, max_size=3), numbers, numbers)
    def send(values, first, last):
        answer = client.ask(
            diagram(parameters={k: float(v) for k, v in values.items()}, span=[first, last])
        )
        assert "defect" not in answer.get("error", "")

    send()
