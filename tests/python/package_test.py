"""The Python package: values against closed forms, printed numbers and the program; shapes; refusals; threads; Ctrl-C.

Usage: package_test.py STRATUS REFERENCE_FOLDER
"""

import csv
import inspect
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
from unittest import mock

import numpy as np
import stratus
from numpy.testing import assert_allclose, assert_array_equal
from small_table import RECIPE, small_table

PROGRAM, REFERENCE = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
HG = "henyey_greenstein:g=0.4"


def run(*arguments, stdin=""):
    return subprocess.run([PROGRAM, *arguments], input=stdin, capture_output=True, text=True)


def random_directions(count, seed):
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


class Package(unittest.TestCase):
    def test_documents_and_types_all_that_it_offers(self):
        functions = []
        for name in stratus.__all__:
            thing = getattr(stratus, name)
            if name != "EffectOptions":
                self.assertTrue(thing.__doc__ and thing.__doc__[0].isupper(), name)
            members = vars(thing).items() if inspect.isclass(thing) else [(name, thing)]
            functions += [(name, member, f) for member, f in members if inspect.isfunction(f) and member[0] != "_"]
        self.assertGreater(len(functions), 20)
        for name, member, function in functions:
            signature = inspect.signature(function)
            self.assertTrue(function.__doc__, (name, member))
            self.assertIsNot(signature.return_annotation, signature.empty, (name, member))
            for parameter in signature.parameters.values():
                self.assertTrue(parameter.name == "self" or parameter.annotation is not parameter.empty, (name, member, parameter))
        self.assertTrue((pathlib.Path(stratus.__file__).parent / "py.typed").exists())


class PhaseFunctions(unittest.TestCase):
    def test_have_their_closed_form(self):
        phi = stratus.PhaseFunction(HG)
        cosines = np.linspace(-1, 1, 12).reshape(3, 4)
        expected = (1 - 0.16) / (1.16 - 0.8 * cosines) ** 1.5
        assert_allclose(phi(cosines), expected, rtol=1e-14)
        assert_allclose(phi.moments(5), 0.4 ** np.arange(5), rtol=1e-14)
        self.assertAlmostEqual(phi.g, 0.4)
        self.assertIsNone(phi.albedo)
        self.assertEqual(stratus.PhaseFunction(phi.text), phi)

    def test_warn_of_what_was_changed(self):
        with self.assertWarnsRegex(UserWarning, "sum"):
            stratus.PhaseFunction("2*isotropic + 2*rayleigh")


class Solver(unittest.TestCase):
    def test_gives_printed_numbers(self):
        with open(REFERENCE / "published.csv", newline="") as file:
            rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#"))
                    if row["phase"] == "isotropic" and row["quantity"] in ("R", "T") and row["source"] == "vdH80"]
        self.assertGreater(len(rows), 5)
        for row in rows:
            light = stratus.solve("isotropic", float(row["w"]), float(row["tau"]), float(row["mu0"]), float(row["mu"]), 0)
            found = light.reflection if row["quantity"] == "R" else light.transmission
            self.assertAlmostEqual(found, float(row["value"]), delta=0.6 * 10.0 ** -(len(row["value"]) - 2))

    def test_meets_the_h_function(self):  # conservative: 4 R (mu + mu0) = H(mu) H(mu0), H(0.5) = 2.01278, H(1) = 2.90781 [C60]
        light = stratus.solve("isotropic", 1, np.inf, [0.5, 1], [1, 1], 0)
        assert_allclose(light.reflection, [2.01278 * 2.90781 / 6, 2.90781**2 / 8], rtol=3e-6)

    def test_solves_many_cosines_in_pieces(self):
        mu = np.linspace(0.01, 1, 150)
        light = stratus.solve(HG, 0.9, 1.5, mu, mu[::-1], 0.3)
        self.assertEqual(light.reflection.shape, (150,))
        assert_allclose(light.reflection, light.reflection[::-1], rtol=1e-11)  # reciprocity
        assert_allclose(light.transmission, light.transmission[::-1], rtol=1e-9, atol=1e-14)
        single = 0.225 * (1 - np.exp(-1.5 / mu - 1.5 / mu[::-1])) / (mu + mu[::-1])
        cosine = np.sqrt((1 - mu**2) * (1 - mu[::-1] ** 2)) * np.cos(0.3) - mu * mu[::-1]
        assert_allclose(light.reflection_single, single * stratus.PhaseFunction(HG)(cosine), rtol=1e-12)

    def test_conserves_energy(self):
        fluxes = stratus.fluxes("rayleigh", 1, 3, [0.2, 0.9])
        assert_allclose(
            fluxes.plane_albedo + fluxes.diffuse_transmittance + fluxes.direct_transmittance, 1, rtol=1e-12)
        self.assertEqual(fluxes.absorptance, 0)
        over = stratus.fluxes("rayleigh", 1, 3, 0.5, below=0.25)
        self.assertAlmostEqual(over.spherical_albedo + over.ground_absorptance, 1, places=12)
        self.assertAlmostEqual(over.absorptance, over.ground_absorptance, places=12)

    def test_takes_a_stack(self):
        halves = '[[layers]]\nphase_function = "rayleigh"\nalbedo = 0.9\noptical_depth = 0.5\n' * 2
        stack = stratus.Stack(halves)
        at = (0.4, [0.3, 0.8], [[0.0], [2.0]])
        assert_allclose(stratus.solve_stack(stack, *at).reflection,
                                   stratus.solve("rayleigh", 0.9, 1, *at).reflection, rtol=1e-12)
        self.assertAlmostEqual(stratus.stack_fluxes(stack, 0.4).plane_albedo[0],
                               stratus.fluxes("rayleigh", 0.9, 1, 0.4).plane_albedo[0], places=12)
        same = stratus.Stack.of(("rayleigh", 0.9, 0.5), (stratus.PhaseFunction("rayleigh"), 0.9, 0.5))
        assert_array_equal(stratus.solve_stack(same, *at).reflection, stratus.solve_stack(stack, *at).reflection)

    def test_broadcasts_layers(self):
        phases = np.array(["rayleigh", stratus.PhaseFunction(HG)], object)[:, None, None]
        albedo, depth, mu = np.array([0.5, 1.0])[:, None], 1.2, [0.3, 0.6, 1.0]
        together = stratus.solve(phases, albedo, depth, 0.8, mu, 1.0)
        self.assertEqual(together.reflection.shape, (2, 2, 3))
        of_all = stratus.fluxes(phases[..., 0], albedo.T, depth, mu)
        self.assertEqual((of_all.spherical_albedo.shape, of_all.plane_albedo.shape), ((2, 2), (2, 2, 3)))
        for i, phase in enumerate(["rayleigh", HG]):
            for j, w in enumerate([0.5, 1.0]):
                assert_array_equal(together.transmission[i, j], stratus.solve(phase, w, depth, 0.8, mu, 1.0).transmission)
                alone = stratus.fluxes(phase, w, depth, mu)
                self.assertEqual(of_all.absorptance[i, j], alone.absorptance)
                assert_array_equal(of_all.plane_albedo[i, j], alone.plane_albedo)

    def test_takes_no_layers(self):
        self.assertEqual(stratus.solve("rayleigh", [], 1, 1, 1, 0).reflection.shape, (0,))
        none = stratus.fluxes("rayleigh", [], [[1], [2]], [0.5, 1])
        self.assertEqual((none.spherical_albedo.shape, none.error.shape), ((2, 0), (2, 0)))
        self.assertEqual((none.plane_albedo.shape, none.direct_transmittance.shape), ((2, 0, 2), (2, 0, 2)))

    def test_gives_the_light_inside(self):
        stack = stratus.Stack.of(("rayleigh", 1, 0.5), (HG, 1, 1.5), below=0.3)
        inside = stratus.stack_fluxes_inside(stack, [0, 0.7, 2], [0.4, 1])
        fluxes = stratus.stack_fluxes(stack, [0.4, 1])
        self.assertEqual(inside.net_flux.shape, (3, 2))
        assert_allclose(inside.net_flux, inside.net_flux[[0]].repeat(3, 0), atol=1e-12)
        assert_allclose(inside.upward_flux[0], fluxes.plane_albedo, rtol=1e-4)
        assert_allclose(inside.diffuse_flux[2], fluxes.diffuse_transmittance, rtol=1e-4)
        self.assertTrue((inside.actinic_flux > 0).all() and (inside.heating_rate == 0).all())
        light = stratus.solve_stack_inside(stack, [[0], [2]], 0.4, [0.3, 0.8], 1.0)
        assert_allclose(light.upward[0], stratus.solve_stack(stack, 0.4, [0.3, 0.8], 1.0).reflection, rtol=1e-4)
        assert_allclose(light.upward[1], 0.3 * (inside.diffuse_flux + inside.direct_flux)[2, 0], rtol=1e-4)  # Lambert
        self.assertTrue((light.downward[0] == 0).all())

    def test_warns_of_missed_tolerances(self):
        def with_errors_of_one(function):
            def call(*arguments):
                found = function(*arguments)
                if isinstance(found, dict):
                    found["relative_error"] = 1
                else:
                    found[-1] = found[-1] + 1
                return found
            return call

        layer, at = (HG, 0.9, 1), (0.5, 0.4, 1)
        stack, solver = stratus.Stack.of(layer), stratus._solve._stratus
        for function, call in (
            ("solve", lambda **how: stratus.solve(*layer, *at, **how)),
            ("solve_stack", lambda **how: stratus.solve_stack(stack, *at, **how)),
            ("solve_stack_inside", lambda **how: stratus.solve_stack_inside(stack, 0.5, *at, **how)),
            ("fluxes", lambda **how: stratus.fluxes(*layer, **how)),
            ("stack_fluxes", lambda **how: stratus.stack_fluxes(stack, **how)),
            ("stack_fluxes_inside", lambda **how: stratus.stack_fluxes_inside(stack, 0.5, **how)),
        ):
            inner = {"solve": "solve_stack", "fluxes": "stack_fluxes"}.get(function, function)
            with mock.patch.object(solver, inner, with_errors_of_one(getattr(solver, inner))):
                with self.assertWarnsRegex(UserWarning, f"^{function}: the tolerance of 0.001 is missed") as met:
                    call(tolerance=1e-3)
                self.assertEqual(met.filename, __file__)
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    call(nodes=16)  # in place of a tolerance
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                call(tolerance=1e-3)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertEqual(stratus.solve(*layer, *at, below=0.3, nodes=16).transmission, 0)
        with self.assertWarnsRegex(UserWarning, "the tolerance of 1e-12 is missed: the largest relative error is some 0.0"):
            stratus.stack_fluxes_inside(stratus.Stack.of(("henyey_greenstein:g=-0.99", 1, 0.01)), 0.005, 0.5, tolerance=1e-12)

    def test_has_the_fluxes_of_the_program(self):
        haze = REFERENCE.parent.parent / "tables" / "stacks" / "haze_over_ground.toml"
        of_layer = "--phase", HG, "--albedo", "0.9", "--optical-depth", "1.5"
        for arguments, found in ((("--layers", haze), stratus.stack_fluxes(stratus.Stack(haze), [0.5, 1])),
                                 (of_layer, stratus.fluxes(HG, 0.9, 1.5, [0.5, 1]))):
            told = json.loads(run("solve", *arguments, "--mu-in", "0.5,1").stdout)
            for name in ("spherical_albedo", "total_transmittance", "absorptance", "plane_albedo", "diffuse_transmittance",
                         "direct_transmittance", "ground_absorptance"):
                assert_allclose(getattr(found, name), told.get(name, 0), rtol=1e-14, err_msg=name)


class Directions(unittest.TestCase):
    def test_are_those_of_observed_angles(self):
        at = stratus.directions([60, 30], [[60], [120]], [[0, 30], [180, 100]])
        assert_allclose(at.mu_in, [[0.5, 3**0.5 / 2]] * 2)
        assert_allclose(at.mu_out, np.full((2, 2), 0.5))
        assert_array_equal(at.side, [["lit"] * 2, ["unlit"] * 2])
        assert_allclose(at.azimuth[:, 0], [np.pi, 0])
        light = stratus.solve(HG, 0.9, 1.5, *at[:3])
        assert_array_equal(light.on(at.side), [light.reflection[0], light.transmission[1]])
        with self.assertRaisesRegex(ValueError, "side must be lit or unlit, got Lit"):
            light.on(["lit", "Lit"])
        seen = at.mu_in * light.on(at.side)
        fit = stratus.fit(seen, 0.01 * seen, **at._asdict(), phase_function=HG)
        self.assertAlmostEqual(fit.value["w"], 0.9, places=3)
        single = stratus.directions(0, 30, 30)
        self.assertEqual((single.side, single.azimuth), ("lit", 0))


class Tables(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_answer_as_the_program(self):
        table, path = small_table(), self.folder / "table.h5"
        table.save(path)
        random = np.random.default_rng(1982)
        at = (random.uniform(0.75, 1, 40), random.uniform(0.5, 2, 40), random.uniform(0.01, 1, 40),
              random.uniform(0.01, 1, 40), random.uniform(0, 180, 40))
        query = io.StringIO()
        np.savetxt(query, np.transpose(at), delimiter=",", comments="", fmt="%.17g",
                   header="albedo,optical_depth,mu_in,mu_out,azimuth_deg")
        answer = np.genfromtxt(io.StringIO(run("eval", path, stdin=query.getvalue()).stdout), delimiter=",", names=True)
        radians = (*at[:4], np.radians(at[4]))
        for table in (table, stratus.load(path)):
            for side in ("reflection", "transmission"):
                look_up = getattr(table, side)
                assert_allclose(look_up(*radians), answer[side], rtol=1e-13)
                assert_allclose(look_up(*radians, multiple=False), answer[side + "_single"], rtol=1e-13)
                assert_allclose(look_up(*radians, single=False), answer[side + "_multiple"], rtol=1e-12)

    def test_are_the_same_in_all_files(self):
        table, at = small_table(), (0.9, [0.6, 1.5], 0.5, [[0.2], [0.9], [1]], 0.7)
        expected = table.reflection(*at)
        self.assertEqual(expected.shape, (3, 2))
        for name, tolerance in (("table.exr", 1e-14), ("table.stratus", 1e-2)):
            table.save(self.folder / name)
            loaded = stratus.load(self.folder / name)
            self.assertEqual(loaded.is_packed, name == "table.stratus")
            assert_allclose(loaded.reflection(*at), expected, rtol=tolerance)
            self.assertEqual(loaded.attributes["title"], "Looked up from Python")
            self.assertEqual(loaded.phase_function.text, HG)
        assert_array_equal(loaded.reflection(*at), table.pack().reflection(*at))

    def test_are_xarrays(self):
        try:
            import xarray  # noqa: F401
        except ImportError as missing:
            self.skipTest(str(missing))
        samples = small_table().to_xarray()
        self.assertEqual(samples.reflection_multiple.dims, ("albedo", "optical_depth", "mu_in", "mu_out", "azimuth"))
        self.assertEqual(samples.albedo.attrs["scale"], "square_root_of_complement")
        self.assertEqual(samples.attrs["phase_function"], HG)
        at = samples.isel(albedo=2, optical_depth=3, mu_in=9, mu_out=12, azimuth=4)
        expected = small_table().reflection(at.albedo, at.optical_depth, at.mu_in, at.mu_out, at.azimuth, single=False)
        assert_allclose(at.reflection_multiple, expected, rtol=1e-6)
        with self.assertRaises(ValueError):
            samples.reflection_multiple.values[:] = 0  # it is the table's own memory
        packed = small_table().pack().to_xarray()
        assert_allclose(packed.reflection_multiple.isel(mu_in=9, mu_out=12),
                                   samples.reflection_multiple.isel(mu_in=9, mu_out=12), rtol=1e-2)
        del samples
        self.assertEqual(float(at.albedo), small_table().axes["albedo"][2])


class Slices(unittest.TestCase):
    def test_are_the_table_at_one_layer(self):
        mu, azimuth = np.linspace(0.05, 1, 9), np.linspace(0, 3, 5)
        expected = small_table().reflection(0.9, 1.5, 0.6, mu[:, None], azimuth)
        found = small_table().bind(1.5, 0.9).reflection(0.6, mu[:, None], azimuth)
        self.assertEqual((found.shape, found.dtype), ((9, 5), np.float32))
        assert_allclose(found, expected, rtol=1e-2)  # the table's tolerance
        three = small_table().bind(1.5, [0.8, 0.9, 1.0]).reflection(0.6, mu[:, None], azimuth)
        self.assertEqual(three.shape, (9, 5, 3))
        assert_allclose(three[..., 1], found, rtol=5e-3)  # refined to the tolerance, unlike
        self.assertEqual(np.shape(small_table().bind(1.5, 0.9).reflection(1, 1, 0)), ())

    def test_evaluate_vectors_as_angles(self):
        layer = small_table().bind(1.5, 0.9)
        mu_in, mu_out, azimuth = 0.6, 0.3, 0.7
        wi = [-np.sqrt(1 - mu_in**2), 0, mu_in]
        s = np.sqrt(1 - mu_out**2)
        wo = np.array([[s * np.cos(azimuth), s * np.sin(azimuth), side * mu_out] for side in (1, -1)])
        assert_allclose(
            np.pi * layer.eval(wi, wo),
            [layer.reflection(mu_in, mu_out, azimuth), layer.transmission(mu_in, mu_out, azimuth)], rtol=1e-5)
        assert_allclose(layer.direct([0.5, 1]), np.exp([-3, -1.5]), rtol=1e-6)
        self.assertGreater(layer.background(0.5), layer.direct(0.5))

    def test_of_single_scattering_have_a_closed_form(self):
        layer = stratus.bind_single("isotropic", 2, 0.8)
        assert_allclose(layer.reflection(0.5, [0.25, 1], 0), 0.2 * -np.expm1([-12, -6]) / [0.75, 1.5], rtol=1e-6)
        wider = stratus.bind_single("isotropic", 1, 0.8, density=0.5)  # the same depth
        assert_allclose(wider.reflection(0.5, 1, 0), layer.reflection(0.5, 1, 0), rtol=1e-6)
        brighter = stratus.bind_single("isotropic", 2, 0.8, opposition=("hapke", 0.05, 0.8))
        back = [0, 0.6, 0.8]
        found = float(brighter.eval(back, back) / layer.eval(back, back))
        self.assertAlmostEqual(found, 1.8, delta=2e-4)  # single precision tells angles to 1e-5 of the law's width

    def test_sample_their_density(self):
        bsdf, count = small_table().bsdf(1.5, 0.9), 200_000
        wi = np.array([0.6, 0, 0.8])
        drawn = bsdf.sample(wi, np.random.default_rng(1982).random((count, 3)))
        assert_allclose(drawn.pdf, bsdf.pdf(wi, drawn.wo), rtol=1e-3)
        assert_allclose(drawn.value, bsdf.eval(wi, drawn.wo), rtol=1e-4)
        nothing = [0, 0, 0]  # drawn where nothing is scattered
        self.assertEqual([float(bsdf.pdf(wi, nothing)), float(bsdf.eval(wi, nothing))], [0, 0])
        # The same mean cosine, over directions spread evenly and weighted by the density. 5 sigma.
        even = random_directions(count, 7)
        density = 4 * np.pi * bsdf.pdf(wi, even)
        for axis in range(3):
            terms = density * even[:, axis]
            sigma = np.hypot(terms.std(), drawn.wo[:, axis].std()) / np.sqrt(count)
            self.assertLess(abs(terms.mean() - drawn.wo[:, axis].mean()), 5 * sigma)
        self.assertLess(abs(density.mean() - 1), 5 * density.std() / np.sqrt(count))
        weight = drawn.value * np.abs(drawn.wo[:, 2]) / drawn.pdf
        reflected, transmitted = bsdf.albedo(0.8)
        self.assertLess(abs(weight.mean() - (reflected + transmitted)), 0.005 * weight.mean())
        exact = stratus.fluxes(HG, 0.9, 1.5, 0.8)
        self.assertAlmostEqual(float(reflected), exact.plane_albedo[0], delta=0.01 * exact.plane_albedo[0])


class Plans(unittest.TestCase):
    SCENE = """
[camera]
distance = 10.0
orthographic_width = 2.2
[sun]
phase_angle_deg = 30.0
[layer]
phase_function = "isotropic"
albedo = {albedo}
optical_depth = 8.0
[planet]
surface = {surface}
"""

    def test_leave_out_what_changes_nothing(self):
        bright = stratus.plan(self.SCENE.format(albedo=0.99, surface=0.3)).scenes[0]
        self.assertIn("multiple", bright.effects)
        self.assertIn('phase_function = \'isotropic\'', bright.recipes[0])
        dark = stratus.plan(self.SCENE.format(albedo=0.0005, surface=0.0)).scenes[0]
        self.assertNotIn("multiple", dark.effects)
        self.assertEqual(dark.recipes, [])
        self.assertIn("multiple", [effect.name for effect in dark.left_out])
        self.assertLessEqual(dark.left_out[0].change, dark.tolerance / 2)

    def test_of_films_keep_what_any_frame_needs(self):
        keys = "".join(f"[[animation.keys]]\nframe = {k}\nlayer.albedo = {albedo}\n" for k, albedo in ((0, 2**-11), (2, 0.75)))
        film = self.SCENE.format(albedo=2**-11, surface=0.0) + "[animation]\nframes = 3\n" + keys
        for measure in (False, True):
            plan = stratus.plan(film, measure=measure).scenes[0]
            self.assertIn("multiple", plan.effects)
            self.assertIn("albedo = { min = 0.00048828125, max = 0.75 }", plan.recipes[0])


class Pictures(unittest.TestCase):
    """A planet without a layer: Lambert's law. Under one: what the program's functions make of its recipe's table."""

    PLANET = {
        "picture": {"width": 24, "height": 16, "samples": 1},
        "camera": {"position": np.array([5.0, 0.0, 0.0]), "orthographic_width": 3},
        "sun": {"phase_angle_deg": 30.0, "visible": False},
        "layer": {"phase_function": "isotropic", "albedo": [0.9, 0.5, 0.1], "optical_depth": 0.0},
        "planet": {"surface": (0.3, 0.6, 0.9)},
    }

    def expect_lambert(self, light, phase_deg):
        right, up = np.meshgrid((np.arange(24) - 11.5) / 8, (7.5 - np.arange(16)) / 8)
        towards = np.sqrt(np.maximum(0, 1 - right**2 - up**2))
        phase = np.radians(phase_deg)
        mu = np.where(towards > 0, np.maximum(0, np.cos(phase) * towards + np.sin(phase) * right), 0)
        self.assertEqual(light.dtype, np.float32)
        assert_allclose(light, mu[..., None] * [0.3, 0.6, 0.9], atol=1e-6)

    def test_show_a_planet_by_lamberts_law(self):
        self.expect_lambert(stratus.render(self.PLANET), 30)

    def test_are_those_of_the_frame(self):
        keys = [{"frame": frame, "sun": {"phase_angle_deg": phase}} for frame, phase in ((0, -60), (3, 30))]
        film = {**self.PLANET, "animation": {"frames": 4, "keys": keys}}
        for frame, phase in enumerate([-60, -30, 0, 30]):
            self.expect_lambert(stratus.render(film, frame=frame, cache=False), phase)
        with self.assertRaisesRegex(ValueError, r"render: frame must be in \[0, 3\], got 4"):
            stratus.render(film, frame=4)

    def test_are_the_same_by_a_table(self):
        scene = Plans.SCENE.format(albedo=0.99, surface=0.3)
        with tempfile.TemporaryDirectory() as folder:
            recipes = stratus.plan(scene).scenes[0].recipes
            paths = [os.path.join(folder, f"{k}.stratus") for k in range(len(recipes))]
            for recipe, path in zip(recipes, paths):
                stratus.bake(recipe).save(path)
            by_table = stratus.render(scene, width=32, table=paths)
        self.assertEqual(by_table.shape, (24, 32, 3))
        baked = stratus.render(scene, width=32, cache=False)
        assert_allclose(by_table, baked, atol=2e-3 * baked.max())
        once = stratus.render(scene, width=32, drop=["multiple"], cache=False)
        assert_array_equal(once, stratus.render(scene, width=32, effects=["-multiple"]))
        self.assertLess(once.sum(), 0.9 * baked.sum())

    def test_refuse_what_is_no_scene(self):
        with self.assertRaisesRegex(ValueError, "unknown key 'sun.colur'"):
            stratus.render({**self.PLANET, "sun": {"colur": 1}})
        with self.assertRaisesRegex(ValueError, "sun.visible must be true or false, got 'yes'"):
            stratus.render({**self.PLANET, "sun": {"phase_angle_deg": 1, "visible": "yes"}})
        for width in 0, 20000:
            with self.assertRaisesRegex(ValueError, rf"width must be in \[1, 16384\], got {width}"):
                stratus.render(self.PLANET, width=width)
        with self.assertRaisesRegex(ValueError, r"tolerance must be in \[1e-6, 0.5\], got 0"):
            stratus.plan(self.PLANET, tolerance=0)
        with self.assertRaisesRegex(ValueError, "unknown effect 'multipel'"):
            stratus.render(self.PLANET, drop=["multipel"])
        with self.assertRaises(FileNotFoundError):
            stratus.render("absent.toml")


class Fits(unittest.TestCase):
    def test_find_a_layer_again(self):
        mu = np.linspace(0.15, 1, 8)
        seen = stratus.solve(HG, 0.7, 1.2, 0.8, mu, 1.0)
        fit = stratus.fit(0.8 * np.stack([seen.reflection, seen.transmission]), 1e-3, mu, mu_in=0.8, azimuth=1.0,
                          side=[["lit"] * 8, ["unlit"] * 8], phase_function=HG)
        self.assertEqual(fit.covariance.shape, (2, 2))
        self.assertAlmostEqual(fit.value["w"], 0.7, places=5)
        self.assertAlmostEqual(fit.value["optical_depth"], 1.2, places=4)
        self.assertEqual(fit.degrees_of_freedom, 14)
        self.assertEqual(fit.residual.shape, (2, 8))
        assert_allclose(fit.model + fit.residual, 0.8 * np.stack([seen.reflection, seen.transmission]), rtol=1e-14)
        self.assertAlmostEqual(((fit.residual / 1e-3) ** 2).sum(), fit.chi_square, places=9)
        assert_allclose(fit.correlation[0, 1] * fit.sigma["w"] * fit.sigma["optical_depth"], fit.covariance[0, 1])
        assert_allclose(np.diag(fit.correlation), 1)
        held = stratus.fit(0.8 * seen.reflection, 1e-3, mu, mu_in=0.8, azimuth=1.0, phase_function=HG, fixed={"w": 0.7})
        self.assertEqual(held.names, ["optical_depth"])
        by_table = stratus.fit(0.8 * seen.reflection, 1e-3, mu, mu_in=0.8, azimuth=1.0, table=small_table(),
                               fixed={"optical_depth": 1.2})
        self.assertTrue(0.74 < by_table.value["w"] < 0.76)  # the table's edge

    def test_find_what_a_table_varies(self):
        lobes = small_table("g_samples = 5\n[family]\ng = [0.2, 0.6]\n")
        mu = np.linspace(0.2, 1, 8)
        light = stratus.solve("henyey_greenstein:g=0.45", 0.9, 1.2, 0.8, mu, 1.0)
        seen = 0.8 * np.stack([light.reflection, light.transmission])
        observed = (seen, 0.01 * seen, mu)
        at = {"mu_in": 0.8, "azimuth": 1.0, "side": [["lit"] * 8, ["unlit"] * 8], "table": lobes}
        fit = stratus.fit(*observed, **at)
        self.assertEqual(fit.names, ["optical_depth", "w", "g"])
        self.assertAlmostEqual(fit.value["g"], 0.45, delta=0.02)
        self.assertAlmostEqual(fit.value["w"], 0.9, delta=0.01)
        self.assertEqual(stratus.fit(*observed, **at, free=["g"]).value, fit.value)
        known = stratus.fit(*observed, **at, family={"g": 0.45})
        self.assertEqual(known.names, ["optical_depth", "w"])
        held = stratus.fit(*observed, **at, fixed={"g": 0.45})
        self.assertEqual(held.value["w"], known.value["w"])
        with self.assertRaisesRegex(ValueError, "family must be of g, got radius"):
            stratus.fit(*observed, **at, family={"radius": 8})
        with self.assertRaisesRegex(ValueError, "g held must be in .0.2, 0.6. of the table, got 0.7"):
            stratus.fit(*observed, **at, fixed={"g": 0.7})

    def test_of_occultations_have_a_closed_form(self):
        fit = stratus.fit(np.exp(-0.8 / 0.5), 0.01, 0.5, side="beam")
        self.assertAlmostEqual(fit.value["optical_depth"], 0.8, places=6)


class Refusals(unittest.TestCase):
    def refused(self, sentence, call, *arguments, kind=ValueError, **named):
        with self.assertRaises(kind) as met:
            call(*arguments, **named)
        self.assertIn(sentence, str(met.exception))
        self.assertNotIn("\n", str(met.exception))

    def test_are_the_sentences_of_the_program(self):
        for command, call in (
            (("phase", "rayliegh"), lambda: stratus.PhaseFunction("rayliegh")),
            (("phase", "tabulated:file=absent.csv"), lambda: stratus.PhaseFunction("tabulated:file=absent.csv")),
            (("info", "absent.h5"), lambda: stratus.load("absent.h5")),
            (("info", PROGRAM + ".stratus"), lambda: stratus.load(PROGRAM + ".stratus")),
            (("bake", "absent.toml", "-o", "a.h5"), lambda: stratus.bake("absent.toml")),
        ):
            with self.assertRaises((ValueError, OSError)) as met:
                call()
            self.assertEqual(run(*command).stderr.splitlines()[-1], "stratus: " + str(met.exception))

    def test_tell_files_from_values(self):
        self.refused("absent.h5", stratus.load, "absent.h5", kind=FileNotFoundError)
        self.refused("absent.stratus", stratus.load, "absent.stratus", kind=FileNotFoundError)
        self.refused("absent.toml", stratus.bake, "absent.toml", kind=FileNotFoundError)
        self.refused("absent.csv", stratus.PhaseFunction, "moments:file=absent.csv", kind=FileNotFoundError)
        self.refused(".h5, .exr or .stratus, got table.txt", stratus.load, "table.txt")
        self.refused("no/such", small_table().save, "no/such/folder.h5", kind=OSError)
        with tempfile.TemporaryDirectory() as folder:
            for name in ("a.h5", "a.exr", "a.stratus"):
                damaged = pathlib.Path(folder) / name
                damaged.write_bytes(b"neither one nor the other")
                self.refused(name, stratus.load, damaged)
        self.refused("unknown key 'tolerence'", stratus.bake, RECIPE.replace("tolerance", "tolerence"))

    def test_name_argument_range_and_value(self):
        table, layer, bsdf = small_table(), small_table().bind(1, 0.9), small_table().bsdf(1, 0.9)
        up = [0, 0, 1]
        self.refused("mu_in must be in (0, 1], got 0", layer.reflection, 0, 1, 0)
        self.refused("mu_out must be in (0, 1], got nan", layer.transmission, 1, [1, np.nan], 0)
        self.refused("azimuth must be finite", layer.reflection, 1, 1, np.inf)
        self.refused("wo must be of length 1 or 0, got 2", layer.eval, up, [0, 0, 2])
        self.refused("3 components", layer.eval, up, [0, 1])
        self.refused("u must be in [0, 1], got 1.5", bsdf.sample, up, [0, 1.5, 0])
        self.refused("albedo must be in [0.75, 1]", table.reflection, 0.7, 1, 1, 1, 0)
        self.refused("optical_depth must be in [0, 2]", table.reflection, 0.9, 2.1, 1, 1, 0)
        self.refused("optical_depth must be in [0, 2]", table.bind, 2.1, 0.9)
        for ground in ('ground = "rpv:rho0=0.1,k=0.7,theta=-0.1"', 'phase_function = "rayleigh"\nalbedo = 0.9'):
            over = small_table("[below]\n" + ground)  # thinner layers than the first have no law
            self.refused("optical_depth must be in [0.5, 2]", over.reflection, 0.9, 0.1, 1, 1, 0)
            self.refused("optical_depth must be in [0.5, 2]", over.bind, 0.1, 0.9)
        single = stratus.bake(RECIPE.replace("min = 0.5, max = 2.0", "min = 1.0, max = 1.0").replace("tolerance = 1e-2", "tolerance = 0.1"))
        self.refused("optical_depth must be in [1, 1]", single.reflection, 0.9, 0.5, 1, 1, 0)
        self.refused("optical_depth must be in [1, 1]", single.bind, 0.5, 0.9)
        self.assertGreater(small_table("[below]\nlambert_albedo = 0.3").reflection(0.9, 0.1, 1, 1, 0), 0.2)
        self.assertTrue(table.bind(2.1, 0.9, clamp=True).clamped)
        self.refused("one number or three, got 2", table.bind, [1, 1.5], 0.9)
        for look_up in (lambda **named: table.reflection(0.9, 1, 1, 1, 0, **named), lambda **named: table.bind(1, 0.9, **named)):
            self.refused("mixture must be 1 or left out of a table that mixes nothing, got 0.3", look_up, mixture=0.3)
            self.refused("mixture must be one number, got [0, 1]", look_up, mixture=[0, 1])
            self.refused("g must be one number, got [0.1, 0.2]", look_up, family={"g": [0.1, 0.2]})
            self.refused("family must map parameters to values, got [0.1]", look_up, family=[0.1])
            look_up(mixture=1)
        self.refused("law must be blinn or hapke, got wide", table.bind, 1, 0.9, opposition="wide")
        for opposition in ("", ("hapke",), ("hapke", 0.1, 0.5, 1), (0.1, 0.5)):
            self.refused("opposition must be a law, or (law, width[, amplitude]), got", table.bind, 1, 0.9, opposition=opposition)
        self.refused("width must be a number", table.bind, 1, 0.9, opposition=("hapke", "wide"))
        self.refused("bind: density must be a number", table.bind, 1, 0.9, density="thick")
        self.refused("bind: density must be one number", table.bind, 1, 0.9, density=[0.1, 0.2])
        self.refused("albedo must be in [0, 1], got 1.5", stratus.solve, HG, 1.5, 1, 1, 1, 0)
        self.refused("cos_scattering_angle must be in [-1, 1], got 2", stratus.PhaseFunction(HG), 2)
        self.refused("packed", table.pack().save, "table.h5")
        self.refused("side must be lit, unlit or beam, got dark", stratus.fit, 1, 1, 1, side="dark")
        self.refused("fixed must be out of optical_depth, w, g, got w1", stratus.fit, 1, 1, 1,
                     phase_function=HG, fixed={"w1": 0.5})
        self.refused("solve: albedo must be a number or an array of numbers, got 'much'", stratus.solve, HG, "much", 1, 1, 1, 0)
        self.refused("solve: arguments must have shapes that broadcast, got phase_function of (), albedo of (3,), "
                     "optical_depth of (), mu_in of (2,)", stratus.solve, HG, [0.1, 0.2, 0.3], 1, [0.5, 1], 1, 0)
        self.refused("fluxes: nodes must be a whole number, got 8.5", stratus.fluxes, HG, 1, 1, nodes=8.5)
        self.refused("fluxes: mu_in must be one number or of shape (n,)", stratus.fluxes, HG, 1, 1, [[1]])
        self.refused("fluxes: nodes must be a whole number, got inf", stratus.fluxes, HG, 1, 1, nodes=np.inf)
        self.refused("solve: tolerance must be one number, got [1, 2]", stratus.solve, HG, 1, 1, 1, 1, 0, tolerance=[1, 2])
        self.refused("phase_function must be a text or a PhaseFunction, got 3", stratus.solve, 3, 1, 1, 1, 1, 0)
        self.refused("fit: fixed w must be a number or an array of numbers, got 'much'", stratus.fit, 1, 1, 1,
                     phase_function=HG, fixed={"w": "much"})
        self.refused("fit: sigma must be a number", stratus.fit, 1, "small", 1)
        self.refused("directions: phase_deg must be in [0, 120] at", stratus.directions, 60, 60, 121)
        self.refused("Stack: albedo must be in [0, 1], got 2", stratus.Stack.of, (HG, 2, 1))
        haze = stratus.Stack.of((HG, 1, 2))
        self.refused("levels must be in [0, 2]", stratus.stack_fluxes_inside, haze, 3)
        self.refused("the optical depth, got nan", stratus.solve_stack_inside, haze, [1, np.nan], 0.5, 0.5, 0)
        self.refused("threads must be in [0, 1024], got -1", stratus.bake, RECIPE, threads=-1)


    def test_name_the_function_that_is_called(self):
        for name, call, *where in (("bind_single", stratus.bind_single, HG), ("Table.bind", small_table().bind),
                                   ("Table.bsdf", small_table().bsdf)):
            self.refused(f"{name}() got an unexpected keyword argument 'foo'", call, *where, 1, 0.9, foo=1, kind=TypeError)
        for albedo, depth, sentence in ((np.nan, 1, "albedo must be in [0, 1], got nan"), (1, -1, "optical_depth must be in [0, inf], got -1")):
            self.refused("solve: " + sentence, stratus.solve, HG, albedo, depth, 1, 1, 0)
            self.refused("fluxes: " + sentence, stratus.fluxes, HG, albedo, depth)
            self.refused("Stack: " + sentence, stratus.Stack.of, (HG, albedo, depth))

    def test_name_what_a_family_lacks(self):
        def look_ups(dense):
            return [call for table in (dense, dense.pack()) for call in (
                lambda **named: table.reflection(0.9, 1, 1, 1, 0, **named),
                lambda **named: table.transmission(0.9, 1, 1, 1, 0, **named),
                lambda **named: table.bind(1, 0.9, **named))]

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            mixed = stratus.bake('second_phase_function = "rayleigh"' + RECIPE + "mixture_samples = 3\n")
        for call in look_ups(mixed):
            self.refused("mixture must be given, of a table that mixes two phase functions, got none", call)
            call(mixture=1)
            call(family={"mixture": 0.5})
        for call in look_ups(small_table("g_samples = 4\n[family]\ng = [0.2, 0.6]\n")):
            self.refused("family must give g, of this table, got none", call)
            call(family={"g": 0.4})

    def test_tell_masked_values(self):
        mu = np.ma.array([0.5, 0.6], mask=[False, True])
        layer = small_table().bsdf(1, 0.9)
        up = np.ma.array([[0, 0, 1.0]], mask=[[False, False, True]])
        for call in (
            lambda: small_table().reflection(0.9, 1, mu, 1, 0),
            lambda: layer.transmission(mu, 1, 0),
            lambda: stratus.solve(HG, 0.9, 1, mu, 1, 0),
            lambda: stratus.fluxes(HG, 0.9, 1, mu),
            lambda: stratus.PhaseFunction(HG)(mu),
            lambda: stratus.fit(1, 1, mu),
            lambda: layer.eval([0, 0, 1], up),
            lambda: layer.sample(up, [0, 0, 0]),
            lambda: stratus.solve(np.ma.array([HG, HG], mask=[True, False]), 0.9, 1, 1, 1, 0),
        ):
            self.refused("must have no masked values, got 1 of them", call)
        unmasked = np.ma.array([0.5, 0.6], mask=False)
        assert_array_equal(layer.reflection(unmasked, 1, 0), layer.reflection([0.5, 0.6], 1, 0))


class LongWork(unittest.TestCase):
    FINE = RECIPE.replace("nodes = 12", "nodes = 48").replace("modes = 9", "modes = 40")

    def test_lets_other_threads_run(self):
        layer = small_table().bind(1, 0.9)
        mu = np.random.default_rng(1).uniform(0.1, 1, 10_000_000).astype(np.float32)
        span = []

        def look_up():
            begun = time.perf_counter()
            layer._own.scattered(False, mu, mu, mu)  # nothing of Python's on the way
            span.extend((begun, time.perf_counter()))

        def runs_beside():
            """True where this thread ran in the second half of the call: with Python's lock held it waits for the end."""
            span.clear()
            thread, ran = threading.Thread(target=look_up), []
            thread.start()
            while not span:
                ran.append(time.perf_counter())
            thread.join()
            return any((span[0] + span[1]) / 2 < when < span[1] for when in ran)

        self.assertTrue(any(runs_beside() for _ in range(5)))  # a busy machine may not let it once

    def test_tells_progress(self):
        stages, notes = [], []
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            stratus.bake(RECIPE, progress=lambda done, stage: stages.append((stage, done)), note=notes.append)
        self.assertIn(("checking", 1.0), stages)
        self.assertTrue(all(0 <= done <= 1 for _, done in stages))
        self.assertTrue(any("random points" in note for note in notes))

    def test_ends_where_a_callback_raises(self):
        class Enough(Exception):
            pass

        def stop(done, stage):
            raise Enough

        before = threading.active_count(), len(os.listdir(f"/proc/{os.getpid()}/task"))
        with self.assertRaises(Enough):
            stratus.bake(self.FINE, progress=stop)
        self.assertEqual((threading.active_count(), len(os.listdir(f"/proc/{os.getpid()}/task"))), before)

    def test_ends_on_ctrl_c_and_leaves_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            script = f"import stratus\nprint('begun', flush=True)\ntable = stratus.bake('''{self.FINE}''')\ntable.save('table.h5')\n"
            path = os.fspath(pathlib.Path(stratus.__file__).resolve().parent.parent)
            with subprocess.Popen([sys.executable, "-c", script], cwd=folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": path}) as bake:
                self.assertEqual(bake.stdout.readline(), "begun\n")
                time.sleep(0.1)
                bake.send_signal(signal.SIGINT)
                _, errors = bake.communicate()
            self.assertEqual(errors.splitlines()[-1], "KeyboardInterrupt")
            self.assertEqual(os.listdir(folder), [])

    def test_warns_of_a_missed_tolerance(self):
        with self.assertWarnsRegex(RuntimeWarning, "misses its tolerance"):
            stratus.bake(RECIPE.replace("mu_samples = 16", "mu_samples = 5"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
