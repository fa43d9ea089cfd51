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

"""Small STEP files (AP214), written from scratch: round plates with round holes, and
assemblies.

All edges but seams are full circles, so that planes and cylinders are the only
surfaces.
"""

from typing import NamedTuple


class Disc(NamedTuple):
    """A round plate on `center`, about the z axis; holes through it are (x, y,
    radius).
    """

    radius: float
    height: float
    holes: tuple = ()
    center: tuple = (0.0, 0.0, 0.0)


class StepText:
    """The entities of a file, numbered as they come; each method returns the number of
    one.
    """

    def __init__(self):
        self.lines = []

    def add(self, entity):
        """Add an entity, and number it."""
        self.lines.append(f"#{len(self.lines) + 1}={entity};")
        return f"#{len(self.lines)}"

    def triple(self, kind, xyz):
        """A point or direction."""
        return self.add(f"{kind}('',({','.join(f'{x:.15E}' for x in xyz)}))")

    def axes(self, *xyz, x=(1.0, 0.0, 0.0), z=(0.0, 0.0, 1.0)):
        """A frame."""
        point = self.triple("CARTESIAN_POINT", xyz)
        return self.add(
            f"AXIS2_PLACEMENT_3D('',{point},{self.triple('DIRECTION', z)},"
            f"{self.triple('DIRECTION', x)})"
        )

    def circle(self, x, y, z, radius):
        """Edge of a full circle, counter-clockwise from above, and its only vertex."""
        vertex = self.add(
            f"VERTEX_POINT('',{self.triple('CARTESIAN_POINT', (x + radius, y, z))})"
        )
        curve = self.add(f"CIRCLE('',{self.axes(x, y, z)},{radius:.15E})")
        return self.add(f"EDGE_CURVE('',{vertex},{vertex},{curve},.T.)"), vertex

    def upright(self, x, y, z, start, end):
        """Edge along z between two vertices."""
        along = self.add(f"VECTOR('',{self.triple('DIRECTION', (0.0, 0.0, 1.0))},1.)")
        line = self.add(f"LINE('',{self.triple('CARTESIAN_POINT', (x, y, z))},{along})")
        return self.add(f"EDGE_CURVE('',{start},{end},{line},.T.)")

    def bound(self, edges, kind):
        """A loop of edges, each with whether it runs forward."""
        oriented_edges = ",".join(
            self.add(f"ORIENTED_EDGE('',*,*,{edge},{logical(forward)})")
            for edge, forward in edges
        )
        loop = self.add(f"EDGE_LOOP('',({oriented_edges}))")
        return self.add(f"{kind}('',{loop},.T.)")

    def face(self, bounds, surface, along=True):
        """Part of a surface."""
        return self.add(
            f"ADVANCED_FACE('',({','.join(bounds)}),{surface},{logical(along)})"
        )

    def solid(self, disc, lost=()):
        """A round plate with its holes; `lost`: faces that it lacks, by number: walls
        of rim and holes, top, bottom.
        """
        x0, y0, z0 = disc.center
        faces = []
        below = []
        above = []
        for k, (x, y, radius) in enumerate([(0.0, 0.0, disc.radius), *disc.holes]):
            x = x0 + x
            y = y0 + y
            rim = k == 0
            low, start = self.circle(x, y, z0, radius)
            high, end = self.circle(x, y, z0 + disc.height, radius)
            seam = self.upright(x + radius, y, z0, start, end)
            edges = [(low, True), (seam, True), (high, False), (seam, False)]
            if not rim:
                edges = [(edge, not forward) for edge, forward in reversed(edges)]
            surface = self.add(
                f"CYLINDRICAL_SURFACE('',{self.axes(x, y, z0)},{radius:.15E})"
            )
            faces.append(
                self.face([self.bound(edges, "FACE_OUTER_BOUND")], surface, rim)
            )
            kind = "FACE_OUTER_BOUND" if rim else "FACE_BOUND"
            below.append(self.bound([(low, not rim)], kind))
            above.append(self.bound([(high, rim)], kind))
        for bounds, z, sense in ((above, z0 + disc.height, 1.0), (below, z0, -1.0)):
            plane = self.add(f"PLANE('',{self.axes(x0, y0, z, z=(0.0, 0.0, sense))})")
            faces.append(self.face(bounds, plane))
        whole = [face for number, face in enumerate(faces) if number not in lost]
        shell = self.add(f"CLOSED_SHELL('',({','.join(whole)}))")
        return self.add(f"MANIFOLD_SOLID_BREP('',{shell})")

    def context(self, unit):
        """Units and accuracy."""
        length = self.length_unit(unit)
        angle = self.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        solid = self.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        slack = self.add(
            f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),{length},"
            "'distance_accuracy_value','')"
        )
        return self.add(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
            f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({slack}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))"
            "REPRESENTATION_CONTEXT('',''))"
        )

    def length_unit(self, unit):
        """A unit of length by its name."""
        prefix = {"m": "$", "mm": ".MILLI.", "cm": ".CENTI.", "inch": ".MILLI."}[unit]
        metric = self.add(f"(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))")
        if unit != "inch":
            return metric
        measure = self.add(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{metric})")
        exponents = self.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
        return self.add(
            f"(CONVERSION_BASED_UNIT('INCH',{measure})LENGTH_UNIT()"
            f"NAMED_UNIT({exponents}))"
        )

    def product(self, name, representation):
        """A named part with its shape."""
        context = self.add("APPLICATION_CONTEXT('automotive design')")
        kind = self.add(f"PRODUCT_CONTEXT('',{context},'mechanical')")
        product = self.add(f"PRODUCT('{name}','{name}','',({kind}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        stage = self.add(
            f"PRODUCT_DEFINITION_CONTEXT('part definition',{context},'design')"
        )
        definition = self.add(f"PRODUCT_DEFINITION('design','',{formation},{stage})")
        shape = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        self.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{representation})")
        return definition

    def text(self):
        """The whole file."""
        return "\n".join(
            [
                "ISO-10303-21;",
                "HEADER;",
                "FILE_DESCRIPTION((''),'2;1');",
                "FILE_NAME('','2026-11-23T00:00:00',(''),(''),'','','');",
                "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));",
                "ENDSEC;",
                "DATA;",
                *self.lines,
                "ENDSEC;",
                "END-ISO-10303-21;",
                "",
            ]
        )


def logical(value):
    """A truth value as STEP writes it."""
    return ".T." if value else ".F."


def step_part(*discs, unit="mm", lost=()):
    """A part of one or several solids; `lost`: see `StepText.solid`."""
    step = StepText()
    solids = [step.solid(disc, lost) for disc in discs]
    items = ",".join([step.axes(0.0, 0.0, 0.0), *solids])
    shape = step.add(
        f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({items}),{step.context(unit)})"
    )
    step.product("part", shape)
    return step.text()


def step_assembly(disc, places):
    """An assembly of the same disc at several places, given as (origin, x axis, z
    axis).
    """
    step = StepText()
    context = step.context("mm")
    frame = step.axes(0.0, 0.0, 0.0)
    shape = step.add(
        f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({frame},{step.solid(disc)}),{context})"
    )
    part = step.product("disc", shape)
    targets = [step.axes(*origin, x=x, z=z) for origin, x, z in places]
    whole = step.add(f"SHAPE_REPRESENTATION('',({','.join(targets)}),{context})")
    assembly = step.product("assembly", whole)
    for number, target in enumerate(targets):
        use = step.add(
            f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}','','',{assembly},{part},$)"
        )
        placed = step.add(f"PRODUCT_DEFINITION_SHAPE('','',{use})")
        move = step.add(f"ITEM_DEFINED_TRANSFORMATION('','',{frame},{target})")
        relation = step.add(
            f"(REPRESENTATION_RELATIONSHIP('','',{shape},{whole})"
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({move})"
            "SHAPE_REPRESENTATION_RELATIONSHIP())"
        )
        step.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{placed})")
    return step.text()
