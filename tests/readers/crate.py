"""Checks the crates of results with the validator of RO-Crate, without a network.

The context of RO-Crate 1.1 is taken from the package rocrate, which carries it.
"""

import email.message
import io
import json
import sys
import urllib.response
from importlib import resources
from types import SimpleNamespace

import rdflib.parser
from rocrate_validator import models, services
from rocrate_validator.utils.http import HttpRequester

CONTEXT = "https://w3id.org/ro/crate/1.1/context"
TEXT = resources.files("rocrate").joinpath("data/ro-crate.jsonld").read_bytes()


def opened(request):
    """The answer to a request for the context."""
    assert request.full_url == CONTEXT, request.full_url
    headers = email.message.Message()
    headers["Content-Type"] = "application/ld+json"
    return urllib.response.addinfourl(io.BytesIO(TEXT), headers, CONTEXT, 200)


def got(url, **_):
    """The same for the validator's own requests."""
    assert url == CONTEXT, url
    headers = {"Content-Type": "application/ld+json"}
    return SimpleNamespace(status_code=200, headers=headers, json=lambda: json.loads(TEXT))


def main(folders):
    rdflib.parser._urlopen = opened
    HttpRequester().get = got
    for folder in folders:
        result = services.validate(
            services.ValidationSettings(
                rocrate_uri=folder,
                profile_identifier="process-run-crate-0.5",
                requirement_severity=models.Severity.REQUIRED,
            )
        )
        problems = [f"{issue.check.identifier}: {issue.message}" for issue in result.get_issues()]
        assert not problems, f"{folder}: " + "; ".join(problems)
        print(f"{folder}: {len(result.executed_checks)} checks passed")
        assert result.executed_checks


if __name__ == "__main__":
    main(sys.argv[1:])
