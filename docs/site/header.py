#!/usr/bin/env python3
"""A header as Doxygen reads it: members that a concept asks for, and aliases that mean the same in
every class, get their description here, once, where the header gives them none.

Usage: header.py FILE.hpp   (writes to standard output; called by Doxygen)
"""
import re
import sys

bsdf = "as gmis::Bsdf asks"
lobes = "as gmis::BsdfWithLobes asks"
light = "as gmis::Light asks"
camera = "as gmis::Camera asks"
scene = "as gmis::Scene asks"
source = "as gmis::UniformSource asks"
proposal_set = "as gmis::ProposalSet asks"

# Name → what it is.
aliases = {
    "S": "the spectrum", "T": "the scalar", "Spectrum": "the spectrum", "Scalar": "the scalar of the spectrum",
    "Bsdf": "the BSDF of the scene", "Light": "the light of the scene", "Camera": "the camera of the scene",
    "Scene": "the scene that it makes", "Point": "a point of a surface", "HitType": "a hit of the scene",
    "Material": "what a surface is made of", "Rgb": "three channels", "Value": "the type of a sample, or of a value",
    "Density": "the type of a density", "result_type": source, "Block": "four words of 32 bits",
    "Context": "what an iteration reads", "Split": "how light trees split", "Output": "where contributions go",
    "Weights": "how weights are formed", "Recursion": "the recursion of the weights", "Sum": "a sum over techniques",
    "Weight": "a weight, or own density and those of the others", "LightPartial": "partial sums of a light subpath",
    "CameraPartial": "partial sums of a camera subpath", "EngineType": "the engine that is run", "Mean": "the type of the mean",
    "Channels": "one number for each channel", "Traits": "how its channels are read", "StoredVertex": "a light vertex",
    "Sample": "what `sample` returns", "Handle": "a shared, immutable object", "ObservesPaths": "marks an output that looks on",
    "Type": "the result",
}
members = {
    "evaluate": bsdf, "is_purely_delta": bsdf, "albedo": bsdf,
    "has_narrow_lobe": "as gmis::has_narrow_lobe asks", "reflects_only": "as gmis::reflects_only asks",
    "is_glossy": "scatters, and without any diffuse part", "max_lobes": lobes, "lobe_count": lobes, "lobe_weight": lobes,
    "sample_lobe": lobes, "lobe_pdfs": lobes, "has_delta_lobes": lobes, "lobes_have_full_support": lobes,
    "is_delta": light, "is_infinite": light, "sample_emission": light, "emitted": light, "next_event_density": light,
    "sample_ray": camera, "project": camera, "has_parallel_rays": camera, "has_lens": "as gmis::Camera allows",
    "intersect": scene, "visible": scene, "sample_light": scene, "selection_probability": scene, "infinite_lights": scene,
    "camera": scene, "min": source, "max": source, "operator()": source, "channel_count": "as gmis::SpectrumTraits",
    "channel": "as gmis::SpectrumTraits", "log_pdf": proposal_set, "log_pdfs": proposal_set, "pdfs": proposal_set,
    "capacity": "the greatest number that fixed storage holds", "exchange_state": "reads or writes the state, by archive",
    "proposal_count": "the number of proposals", "require_fits": "std::invalid_argument where the counts do not fit",
    "merge": "adds what another one has counted",
}

constants = {"max_lobes", "channel_count", "capacity"}

declaration = re.compile(
    r"^\s+(?:\[\[nodiscard\]\]\s*)?(?:(?:static|constexpr|inline|friend|explicit|const|consteval|virtual|auto)\s+)*"
    r"(?P<type>[A-Za-z_][\w:<>,*& .()]*?[\s*&])?(?P<name>operator\(\)|[A-Za-z_]\w*)\s*(?P<rest>[({=;]|$)")
lines = open(sys.argv[1], encoding="utf-8").read().split("\n")
out = []
is_documented = False
templated = []
for line in lines:
    stripped = line.strip()
    alias = re.match(r"^(\s+)using (\w+)\b", line)
    if stripped.startswith("template") or stripped.startswith("requires"):
        templated.append(line)
        continue
    brief = None
    if not is_documented and "///<" not in line and line.startswith("  ") and not line.startswith("    "):
        if alias and alias.group(2) in aliases:
            brief = aliases[alias.group(2)]
        elif not alias:
            found = declaration.match(line)
            if found and found.group("type") and found.group("type").strip() not in ("return", "else", "new", "case") \
                    and found.group("name") in members \
                    and (found.group("rest") == "(" or found.group("name") in constants):
                brief = members[found.group("name")]
    if brief:
        out.append(f"  /// {brief[0].upper()}{brief[1:]}.")
    out += templated
    templated = []
    out.append(line)
    is_documented = stripped.startswith("///") or (is_documented and not stripped)
sys.stdout.write("\n".join(out + templated))
