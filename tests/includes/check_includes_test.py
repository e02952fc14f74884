#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The include rule can fail: a small tree with one sin at a time, and one without."""

import pathlib
import tempfile
import unittest

import check_includes

GOOD = {
    "src/roadquery/road_map.hpp": "#include <vector>\n",
    "src/orthodrive/core/CMakeLists.txt": "orthodrive_library(core LIBS fmt::fmt)\n",
    "src/orthodrive/core/error.hpp": "#include <string>\n",
    "src/orthodrive/core/hash.cpp": '#include <fstream>\nvoid f() { std::ifstream in("a"); }\n',
    "src/orthodrive/model/CMakeLists.txt": (
        "orthodrive_library(model DEPS core LIBS fmt::fmt)\n# words\n"
        "target_link_libraries(orthodrive_model PUBLIC roadquery)\n"
    ),
    "src/orthodrive/model/photo.hpp": '#include "orthodrive/core/error.hpp"\n#include "roadquery/road_map.hpp"\n',
    "src/orthodrive/io/CMakeLists.txt": "orthodrive_library(io FOLDERS support\n  DEPS model LIBS GDAL::GDAL)\n",
    "src/orthodrive/io/read_photo.hpp": '#include "orthodrive/model/photo.hpp"\n',
    "src/orthodrive/io/support/gdal_support.hpp": "#include <gdal_priv.h>\n",
    "src/orthodrive/refine/CMakeLists.txt": "orthodrive_library(refine DEPS model)\n",
    "src/orthodrive/refine/refine_roads.hpp": '#include "orthodrive/model/photo.hpp"\n',
    "src/orthodrive/refine/refine_roads.cpp": (
        '#include "orthodrive/refine/refine_roads.hpp"\n#include <ceres/ceres.h>'
        '\n// an ifstream in a comment, "fopen" in a string\nauto s = '
        '"fopen";\n'
    ),
    "src/orthodrive/network/CMakeLists.txt": "orthodrive_library(network DEPS model)\n",
    "src/orthodrive/network/build_network.hpp": '#include "orthodrive/core/error.hpp"\n',
    "src/orthodrive/pipeline/CMakeLists.txt": (
        "orthodrive_library(pipeline COLD FOLDERS files stages\n  DEPS io refine network)\n"
    ),
    "src/orthodrive/pipeline/stages/run_refine.cpp": (
        '#include "orthodrive/io/read_photo.hpp"\n#include "orthodrive/refine/refine_roads.hpp"\n#include <fstream>\n'
    ),
    "src/orthodrive/pipeline/stages/run_refine.hpp": '#include "orthodrive/pipeline/files/toml_section.hpp"\n',
    "src/orthodrive/pipeline/files/toml_section.hpp": "\n",
    "src/orthodrive/pipeline/runs.hpp": '#include "orthodrive/pipeline/stages/run_refine.hpp"\n',
    "lab/orthodrive/lab/CMakeLists.txt": "orthodrive_library(lab FOLDERS commands DEPS pipeline)\n",
    "lab/orthodrive/lab/commands/run_synth.hpp": '#include "orthodrive/pipeline/runs.hpp"\n',
    "lab/app/cmd_synth.cpp": '#include "orthodrive/lab/commands/run_synth.hpp"\n#include "main.hpp"\n',
    "app/main.hpp": "\n",
    "app/main.cpp": '#include "orthodrive/pipeline/stages/run_refine.hpp"\n',
}


class Includes(unittest.TestCase):
    def findings(self, **changes):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {**GOOD, **changes.get("files", {})}.items():
                file = pathlib.Path(folder, name)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
            return check_includes.check(pathlib.Path(folder))[0]

    def expect(self, name, text, *words):
        found = self.findings(files={name: text})
        self.assertEqual(len(found), 1, found)
        for word in words:
            self.assertIn(word, found[0])

    def test_a_tree_that_obeys_has_no_findings(self):
        self.assertEqual(self.findings(), [])

    def test_a_stage_includes_a_stage_though_it_is_header_only(self):
        self.expect(
            "src/orthodrive/refine/odd.hpp",
            '#include "orthodrive/network/build_network.hpp"\n',
            "refine/odd.hpp",
            "no arrow",
        )

    def test_a_stage_includes_io(self):
        self.expect(
            "src/orthodrive/refine/odd.cpp",
            '  #  include "orthodrive/io/read_photo.hpp"\n',
            "no arrow leads from refine to io",
        )

    def test_a_stage_links_a_stage(self):
        self.expect(
            "src/orthodrive/refine/CMakeLists.txt",
            "orthodrive_library(refine DEPS model\n  network)\n",
            "a stage reaches network",
        )

    def test_a_stage_links_io_through_another_room(self):
        found = self.findings(
            files={
                "src/orthodrive/roads/CMakeLists.txt": "orthodrive_library(roads DEPS io)\n",
                "src/orthodrive/refine/CMakeLists.txt": "orthodrive_library(refine DEPS model roads)\n",
            }
        )
        self.assertEqual(found, ["refine: a stage reaches io by its DEPS"])

    def test_an_arrow_upwards(self):
        self.expect("src/orthodrive/core/odd.hpp", '#include "orthodrive/model/photo.hpp"\n', "core to model")

    def test_rooms_in_a_circle(self):
        found = self.findings(files={"src/orthodrive/core/CMakeLists.txt": "orthodrive_library(core DEPS model)\n"})
        self.assertIn("core: a circle of DEPS", found)

    def test_files_in_a_circle(self):
        found = self.findings(
            files={
                "src/orthodrive/network/a.hpp": '#include "orthodrive/network/b.hpp"\n',
                "src/orthodrive/network/b.hpp": '#include "orthodrive/network/a.hpp"\n',
            }
        )
        self.assertEqual(
            found,
            ["a circle of includes: orthodrive/network/a.hpp -> orthodrive/network/b.hpp -> orthodrive/network/a.hpp"],
        )

    def test_a_stage_opens_a_file(self):
        self.expect("src/orthodrive/refine/odd.cpp", "#include <fstream>\n", "<fstream>", "opens no file")
        self.expect(
            "src/orthodrive/refine/odd.cpp",
            '#include <filesystem>\nbool f() { return std::filesystem::exists("a"); }\n',
            "exists",
        )
        self.expect("src/orthodrive/model/odd.cpp", 'void f() { fopen("a", "r"); }\n', "fopen")
        self.expect("src/orthodrive/network/odd.cpp", "#include <gdal_priv.h>\n", "gdal")

    def test_a_header_shows_a_library(self):
        self.expect("src/orthodrive/refine/odd.hpp", "#include <ceres/ceres.h>\n", "ceres")
        self.expect("src/orthodrive/model/odd.hpp", "#include <boost/geometry.hpp>\n", "boost")
        self.expect("src/orthodrive/pipeline/odd.hpp", "#include <gdal_priv.h>\n", "gdal")

    def test_intrinsics_stay_in_what_is_compiled_per_processor(self):
        kernel = "src/orthodrive/core/kernel.inl"
        files = {kernel: "#include <immintrin.h>\n", "src/orthodrive/core/kernel.cpp": '#include "kernel.inl"\n'}
        self.assertEqual(self.findings(files=files), [])
        self.expect("src/orthodrive/core/odd.hpp", "#include <immintrin.h>\n", "odd.hpp", "immintrin")
        found = self.findings(files={**files, "src/orthodrive/core/odd.hpp": '#include "kernel.inl"\n'})
        self.assertEqual(len(found), 1, found)
        self.assertIn("one family of processors", found[0])

    def test_the_command_line_calls_a_stage(self):
        self.expect(
            "app/cmd_odd.cpp", '#include "orthodrive/network/build_network.hpp"\n', "cmd_odd.cpp", "the command line"
        )

    def test_a_file_that_is_not_there(self):
        self.expect("src/orthodrive/refine/odd.cpp", '#include "orthodrive/refine/gone.hpp"\n', "gone.hpp")

    def test_an_arrow_upwards_inside_a_room(self):
        self.expect(
            "src/orthodrive/pipeline/files/output_lock.hpp",
            '#include "orthodrive/pipeline/stages/run_refine.hpp"\n',
            "files comes before stages",
        )
        self.expect(
            "src/orthodrive/pipeline/stages/run_refine.cpp",
            '#include "orthodrive/pipeline/runs.hpp"\n',
            "stages comes before pipeline itself",
        )

    def test_an_arrow_upwards_inside_a_room_beside_the_others(self):
        files = {
            "src/roadquery/CMakeLists.txt": "set(FOLDERS map query)\n",
            "src/roadquery/query/road_query.hpp": '#include "roadquery/map/driving_side.hpp"\n',
            "src/roadquery/map/driving_side.hpp": "\n",
        }
        self.assertEqual(self.findings(files=files), [])
        files["src/roadquery/map/driving_side.cpp"] = '#include "roadquery/query/road_query.hpp"\n'
        self.assertIn("map comes before query", "".join(self.findings(files=files)))

    def test_a_folder_of_a_room_that_is_not_listed(self):
        self.expect("src/orthodrive/pipeline/more/part.hpp", "\n", "FOLDERS and the folder more do not agree")

    def test_a_folder_of_many_files(self):
        files = {f"src/orthodrive/core/part_{i}.hpp": "\n" for i in range(39)}
        self.assertEqual(self.findings(files=files), ["orthodrive/core: 41 files, at most 40"])

    def test_a_name_in_two_folders(self):
        name = "src/orthodrive/network/refine_roads.cpp"
        self.expect(name, "\n", "refine_roads: stands in orthodrive/network and orthodrive/refine")

    def test_the_product_knows_the_laboratory(self):
        self.expect(
            "src/orthodrive/refine/odd.cpp",
            '#include "orthodrive/lab/commands/run_synth.hpp"\n',
            "no arrow leads from refine to lab",
        )
        self.expect(
            "src/orthodrive/refine/CMakeLists.txt",
            "orthodrive_library(refine DEPS model attic)\n",
            "DEPS name attic",
        )
        files = {
            "lab/orthodrive/synth/CMakeLists.txt": "orthodrive_library(synth DEPS model)\n",
            "src/orthodrive/io/CMakeLists.txt": "orthodrive_library(io FOLDERS support\n  DEPS synth)\n",
        }
        found = [f for f in self.findings(files=files) if f.startswith("io: ")]
        self.assertEqual(found, ["io: a room of the product reaches synth of the laboratory by its DEPS"])
        self.expect(
            "app/cmd_odd.cpp", '#include "orthodrive/lab/commands/run_synth.hpp"\n', "cmd_odd.cpp", "the command line"
        )

    def test_a_folder_without_a_target(self):
        self.expect("src/orthodrive/attic/odd.cpp", "\n", "no target attic")


unittest.main()
