# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Files that a message names in place of a mesh, and which of them a node reads.

Whoever can send a message can name any file of the machine, so that only those in
installed packages and below the folders of a parameter are read.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import numpy as np
from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_share_directory,
)

from ...base.errors import RequestError
from ...core.mesh import files, units
from ..messages.part_requests import PartRequest, quote_text


def read_resource(
    request: PartRequest, folders: Sequence[str], most_bytes: int
) -> PartRequest:
    """The request with the mesh of its file, in the unit that it or the request names.

    Raises MeshFileError, RequestError, also where neither does: a cell would act on a
    guess.
    """
    mesh = files.read_mesh(
        resource_file(request.resource, folders),
        request.resource_unit or None,
        unless_declared=True,
        most_bytes=most_bytes,
    )
    if mesh.unit_guessed:
        raise units.missing_unit(
            f"mesh_resource {quote_text(request.resource)}",
            mesh.vertices,
            mesh.triangles,
            "fill in mesh_resource_unit: mm, inch or m",
        )
    return replace(
        request,
        vertices=np.asarray(mesh.vertices),
        triangles=np.asarray(mesh.triangles, np.uint32),
        unit=mesh.unit,
        resource="",
        resource_unit="",
    )


def resource_file(uri: str, folders: Sequence[str]) -> Path:
    """The file that a mesh_resource names, without links; raises RequestError."""
    scheme, separator, path = uri.partition("://")
    package, _, name = path.partition("/")
    allowed = [Path(folder) for folder in folders]
    quoted_uri = quote_text(uri)
    is_in_package = separator and scheme == "package" and package and name
    if is_in_package:
        try:
            share = Path(get_package_share_directory(package))
        except (PackageNotFoundError, ValueError, OSError) as error:
            raise RequestError(
                "mesh_resource in a package that is installed",
                quoted_uri,
                "source its workspace",
            ) from error
        file = share / unquote(name)
        allowed.append(share)
    elif separator and scheme == "file" and not package and name:
        file = Path("/", unquote(name))
    else:
        raise RequestError(
            "mesh_resource as package://PACKAGE/FILE or file:///FILE",
            quoted_uri,
            "write out the whole path",
        )
    try:
        resolved = file.resolve()
        is_allowed = any(
            resolved.is_relative_to(folder.resolve()) for folder in allowed
        )
    except (OSError, RuntimeError, ValueError):  # links in a circle, no name at all
        is_allowed = False
    if not is_allowed:
        raise RequestError(
            "mesh_resource within the share folder of its package, links resolved, "
            "or below a folder of the parameter mesh_folders",
            quoted_uri,
            "name its folder in mesh_folders, or send the mesh itself",
        )
    return resolved
