"""The engine inside another renderer, over that renderer's intersection, BSDFs, lights and camera,
beside its own integrators.

Takes the name of the renderer, `smallvcm`, `lajolla` or `tungsten`, and a checkout of it, of which
nothing is changed; bench/embedded/ has an adapter and a program for each, and
bench/embedded/*/measure.py says what is measured. Without a checkout nothing is.
"""

import importlib
import pathlib

BY_ITSELF = False
RENDERERS = ("smallvcm", "lajolla", "tungsten")


def add_options(parser):
    parser.add_argument("renderer", choices=RENDERERS)
    parser.add_argument("checkout", type=pathlib.Path, help="of that renderer")


def run(options):
    measure = importlib.import_module(f"embedded.{options.renderer}.measure")
    options.checkout = options.checkout.resolve()
    if not (options.checkout / measure.A_FILE).is_file():
        raise SystemExit(f"embedded: {options.checkout} is no checkout of {options.renderer}: it has no {measure.A_FILE}")
    options.name = f"embedded {options.renderer}"
    options.out = options.out / options.renderer
    options.out.mkdir(exist_ok=True)
    measure.run(options)
