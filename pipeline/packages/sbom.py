#!/usr/bin/env python3
"""sbom.py SOURCES VERSION COMMIT FILE...: what programs and libraries were linked with, as SPDX 2.3 in JSON on the standard output.

Each FILE is asked which libraries it needs, and dpkg to which packages these belong, in which version. Beside them stand what is
compiled in from headers alone, and what the viewer's package-lock.json packs into pages. The time is SOURCE_DATE_EPOCH's.
"""
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys

HEADERS = ["libcli11-dev", "libtinygltf-dev", "nlohmann-json3-dev", "pybind11-dev"]


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def libraries_of(binary):
    """The paths of the libraries that the file itself names, not of those that they need in turn."""
    needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", output_of("readelf", "-dW", binary)))
    paths = dict(re.findall(r"^\t(\S+) => (\S+)", output_of("ldd", binary), re.M))
    return {os.path.realpath(paths[name]) for name in needed if name in paths}


def packages_of(files):
    """The packages that own the files, sorted. The project's own library has none, of which dpkg complains."""
    names = [*files, *(name.removeprefix("/usr") for name in files)]  # some packages hold /lib, a link to /usr/lib
    owners = subprocess.run(["dpkg-query", "-S", *names], capture_output=True, text=True, check=False).stdout
    return sorted({line.split(":")[0] for line in owners.splitlines()})


def debian_package(name):
    fields = output_of("dpkg-query", "-W", "-f", "${Version}\t${Architecture}\t${Homepage}\n", name).splitlines()[0]
    version, architecture, home = fields.split("\t")
    return {
        "name": name, "versionInfo": version, "homepage": home or "NONE",
        "externalRefs": [purl(f"pkg:deb/debian/{name}@{version}?arch={architecture}&distro=debian-12")],
    }


def npm_packages(sources):
    lock = json.loads((sources / "exporters/viewer/package-lock.json").read_text())
    for place, package in lock["packages"].items():
        if place and not package.get("dev"):
            name = place.rpartition("node_modules/")[2]
            yield {
                "name": name, "versionInfo": package["version"], "licenseDeclared": package["license"],
                "externalRefs": [purl(f"pkg:npm/{name}@{package['version']}")],
            }


def purl(locator):
    return {"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": locator}


def document(sources, version, commit, binaries):
    libraries = packages_of(set().union(*map(libraries_of, binaries)))
    installed = output_of("dpkg-query", "-W", "-f", "${Package} ${db:Status-Status}\n").splitlines()
    headers = [name for name in HEADERS if f"{name} installed" in installed]
    found = [("DYNAMIC_LINK", debian_package(name)) for name in libraries]
    found += [("STATIC_LINK", debian_package(name)) for name in headers]
    found += [("CONTAINS", package) for package in npm_packages(sources)]
    packages = [{"name": "hexrelief", "versionInfo": version, "licenseDeclared": "MIT", "sourceInfo": f"commit {commit}"}]
    packages += [package for _, package in found]
    for package in packages:
        package["SPDXID"] = "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", package["name"])
        package.setdefault("downloadLocation", "NOASSERTION")
        package["filesAnalyzed"] = False
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH") or datetime.datetime.now().timestamp())
    links = [("SPDXRef-DOCUMENT", "DESCRIBES", packages[0])]
    links += [("SPDXRef-hexrelief", how, package) for how, package in found]
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"hexrelief-{version}",
        "documentNamespace": f"https://hexrelief.invalid/spdx/{version}/{commit}/{seconds}",
        "creationInfo": {
            "created": datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
            "creators": ["Tool: hexrelief sbom.py"],
        },
        "packages": packages,
        "relationships": [
            {"spdxElementId": one, "relationshipType": how, "relatedSpdxElement": other["SPDXID"]} for one, how, other in links
        ],
    }


if __name__ == "__main__":
    print(json.dumps(document(pathlib.Path(sys.argv[1]), *sys.argv[2:4], sys.argv[4:]), indent=1))
