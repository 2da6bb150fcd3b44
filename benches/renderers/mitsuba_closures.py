"""Compares closures with Mitsuba's, value by value: reads what the program `closures` writes.

Mitsuba masks and shadows microfacets independently of each other, G = G1(wo) G1(wi); the closures do by height,
G = 1 / (1/G1(wo) + 1/G1(wi) - 1). Its values are multiplied by the ratio of the two, with its own G1. What it carries is
radiance, so its refraction has a factor eta^2 that basic radiance has not.
"""

import json
import sys

TOLERANCE = 1e-4


def main():
    try:
        import mitsuba as mi
    except ImportError:
        print("skipped: there is no Mitsuba (benches/setup-renderers.sh installs it)")
        sys.stdin.read()
        return 0
    mi.set_variant("scalar_rgb")
    worst = {}
    models = {}
    for line in sys.stdin:
        query = json.loads(line)
        exact = MODELS[query["model"]](mi, query, models)
        error = abs(query["value"] - exact) / max(1.0, abs(exact))
        count, greatest, at = worst.get(query["model"], (0, -1.0, None))
        worst[query["model"]] = (count + 1, max(greatest, error), (query, exact) if error > greatest else at)
    for model, (count, greatest, (query, exact)) in worst.items():
        print(f"{model:17} {count:6} values, greatest error {greatest:.1e} of max(1, value)")
        if greatest > TOLERANCE:
            print(f"    Mitsuba: {exact}; {query}")
    return int(not worst or any(greatest > TOLERANCE for _, greatest, _ in worst.values()))


def evaluate(mi, bsdf, wo, wi):
    """Mitsuba names the directions the other way round."""
    interaction = mi.SurfaceInteraction3f()
    interaction.wi = wo
    return bsdf.eval(mi.BSDFContext(), interaction, wi)[0]


def load(mi, models, **description):
    key = json.dumps(description)
    if key not in models:
        models[key] = mi.load_dict(description)
    return models[key]


def masking(mi, query, wo, wi, half):
    """The closures' G over Mitsuba's."""
    facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, *query["alpha"], False)
    a, b = facets.smith_g1(wo, half), facets.smith_g1(wi, half)
    return 0.0 if a == 0.0 or b == 0.0 else 1.0 / (1.0 / a + 1.0 / b - 1.0) / (a * b)


def diffuse(mi, query, models):
    return evaluate(mi, load(mi, models, type="diffuse"), query["wo"], query["wi"])


def conductor(mi, query, models):
    return mi.fresnel_conductor(query["cos"], mi.Complex2f(query["n"], query["k"]))


def rough_conductor(mi, query, models):
    x, y = query["alpha"]
    bsdf = load(mi, models, type="roughconductor", material="none", distribution="ggx", alpha_u=x, alpha_v=y)
    wo, wi = mi.ScalarVector3f(query["wo"]), mi.ScalarVector3f(query["wi"])
    half = normalized(wo + wi)
    return evaluate(mi, bsdf, wo, wi) * masking(mi, query, wo, wi, half)


def rough_dielectric(mi, query, models):
    x, y = query["alpha"]
    ior = query["ior"]
    bsdf = load(mi, models, type="roughdielectric", distribution="ggx", int_ior=ior, ext_ior=1.0, alpha_u=x, alpha_v=y)
    wo, wi = mi.ScalarVector3f(query["wo"]), mi.ScalarVector3f(query["wi"])
    here, beyond = (ior, 1.0) if query["inside"] else (1.0, ior)
    is_refracted = wi.z < 0.0
    half = normalized(here * wo + beyond * wi) if is_refracted else normalized(wo + wi)
    if half.z < 0.0:
        half = -half
    value = masking(mi, query, wo, wi, half)
    if is_refracted:
        value *= (beyond / here) ** 2
    if query["inside"]:
        wo.z, wi.z = -wo.z, -wi.z
    return value * evaluate(mi, bsdf, wo, wi)


def thin_dielectric(mi, query, models):
    bsdf = load(mi, models, type="thindielectric", int_ior=query["ior"], ext_ior=1.0)
    interaction = mi.SurfaceInteraction3f()
    interaction.wi = query["wo"]
    sample, _ = bsdf.sample(mi.BSDFContext(), interaction, 0.0, [0.5, 0.5])
    return sample.pdf if sample.wo.z > 0.0 else 1.0 - sample.pdf


def normalized(vector):
    return vector / sum(x * x for x in vector) ** 0.5


MODELS = {
    "diffuse": diffuse,
    "conductor": conductor,
    "rough conductor": rough_conductor,
    "rough dielectric": rough_dielectric,
    "thin dielectric": thin_dielectric,
}

if __name__ == "__main__":
    sys.exit(main())
