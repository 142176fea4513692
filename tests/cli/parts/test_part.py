"""Parts of a dataset that one process makes one after the other, and options whose value may be left out."""

from tests.cli.datasets import FRAMES, content, generate, merge, run, write_job
from tests.sampled_cases import in_soak
from usdsdg.cli.commands.generate import make_part
from usdsdg.cli.options.optional_values import completed


@in_soak
def test_one_process_makes_all_parts(tmp_path):
    job = write_job(tmp_path, "CocoWriter", splits={"train": 2, "val": 1})
    assert generate(job, tmp_path / "whole", fresh=True).returncode == 0
    given = ["generate", "-q", str(job), "--device", "cpu", "--set", f"writer_kwargs.output_dir={tmp_path}/out"]
    for first, last in ((0, 2), (2, 3), (3, FRAMES)):
        code, said = make_part([*given, "--frames", f"{first}:{last}", "--resume"])
        assert code == 0, said
    assert merge(tmp_path / "out").returncode == 0
    assert content(tmp_path / "out") == content(tmp_path / "whole")


def test_a_part_that_fails_tells_its_exit_code_and_what_it_said(tmp_path):
    code, said = make_part(["generate", str(tmp_path / "none.yaml")])
    assert code == 1
    assert "there is no file" in said


def test_the_address_of_a_cluster_may_be_left_out(tmp_path):
    (tmp_path / "job.yaml").write_text("")
    job = str(tmp_path / "job.yaml")
    assert completed(["generate", job, "--ray"]) == ["generate", job, "--ray", "local"]
    assert completed(["generate", "--ray", job]) == ["generate", "--ray", "local", job]
    assert completed(["generate", job, "--ray", "--workers", "2"]) == [
        "generate",
        job,
        "--ray",
        "local",
        "--workers",
        "2",
    ]
    assert completed(["generate", job, "--ray", "auto"]) == ["generate", job, "--ray", "auto"]
    assert completed(["run", "script.py", "--ray"]) == ["run", "script.py", "--ray"]
    assert completed([]) == []


def test_ray_that_is_not_installed_is_named(tmp_path, monkeypatch):
    job = write_job(tmp_path, "CocoWriter")
    (tmp_path / "ray.py").write_text("raise ImportError")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")
    done = generate(job, tmp_path / "out", "--ray")
    assert done.returncode == 1
    assert "pip install 'usdsdg[ray]'" in done.stderr


def test_a_part_leaves_nothing_to_be_written_at_exit(tmp_path):
    job = write_job(tmp_path, "CocoWriter")
    given = ["generate", "-q", str(job), "--device", "cpu", "--set", f"writer_kwargs.output_dir={tmp_path}/out"]
    code = (
        "import shutil, sys; from usdsdg.cli.commands.generate import make_part\n"
        f"given = {given!r}\n"
        "said = [make_part([*given, '--frames', part, '--resume']) for part in ('0:1', '1:2')]\n"
        f"shutil.rmtree('{tmp_path}/out')\n"
        "sys.exit(any(code or 'several writers' in text for code, text in said))"
    )
    done = run(["-c", code])
    assert (done.returncode, "error" in done.stderr) == (0, False), done.stderr
