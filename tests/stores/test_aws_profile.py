"""What `aws configure` wrote counts where the environment says nothing."""

from pathlib import Path

import pytest

from tests.stores.servers import KEYS, Bucket, only_ours
from usdsdg.errors import StoreError
from usdsdg.stores import open_store
from usdsdg.stores.aws_profile import aws_profile

CREDENTIALS = """
[default]
aws_access_key_id = one
aws_secret_access_key = %of=default
[lab]
aws_access_key_id = two
aws_secret_access_key = of-lab
aws_session_token = token
"""
CONFIG = """
[default]
region = eu-central-1
[profile lab]
region = us-west-2
endpoint_url = http://127.0.0.1:1
[profile signed-in]
sso_session = work
"""


@pytest.fixture(autouse=True)
def files(monkeypatch, tmp_path):
    only_ours(monkeypatch, str(tmp_path / "none"))
    for name in (*KEYS, "AWS_REGION"):
        monkeypatch.delenv(name)
    for name, text in (("AWS_SHARED_CREDENTIALS_FILE", CREDENTIALS), ("AWS_CONFIG_FILE", CONFIG)):
        (tmp_path / name).write_text(text, encoding="utf-8")
        monkeypatch.setenv(name, str(tmp_path / name))


def test_the_default_profile():
    assert aws_profile() == {"access_key_id": "one", "secret_access_key": "%of=default", "region": "eu-central-1"}


def test_a_named_profile(monkeypatch):
    monkeypatch.setenv("AWS_PROFILE", "lab")
    assert aws_profile() == {
        "access_key_id": "two", "secret_access_key": "of-lab", "session_token": "token",
        "region": "us-west-2", "endpoint": "http://127.0.0.1:1",
    }  # fmt: skip


def test_the_environment_comes_first(monkeypatch):
    monkeypatch.setenv("AWS_PROFILE", "lab")
    for name, value in (*KEYS.items(), ("AWS_REGION", "eu-west-1"), ("AWS_ENDPOINT_URL_S3", "http://127.0.0.1:2")):
        monkeypatch.setenv(name, value)
    assert aws_profile() == {"endpoint": "http://127.0.0.1:2"}


def test_profiles_that_are_not_there_or_need_a_log_in_are_told(monkeypatch):
    monkeypatch.setenv("AWS_PROFILE", "typo")
    with pytest.raises(StoreError, match=r"AWS_PROFILE is 'typo'.*aws configure"):
        aws_profile()
    monkeypatch.setenv("AWS_PROFILE", "signed-in")
    with pytest.raises(StoreError, match="export-credentials"):
        aws_profile()


def test_a_broken_file_is_told(tmp_path):
    (tmp_path / "AWS_CONFIG_FILE").write_text("region = without a section", encoding="utf-8")
    with pytest.raises(StoreError, match="AWS_CONFIG_FILE cannot be read"):
        aws_profile()


def test_a_bucket_opens_with_a_profile(monkeypatch, tmp_path):
    bucket = Bucket()
    text = f"[default]\naws_access_key_id=a\naws_secret_access_key=b\nregion=us-east-1\nendpoint_url={bucket.url}\n"
    (tmp_path / "AWS_CONFIG_FILE").write_text(text, encoding="utf-8")
    open_store(f"s3://{bucket.name}").put("x", b"1")
    assert bucket.objects == {"x": b"1"}


def test_a_user_without_a_home_has_no_profile(monkeypatch):
    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", no_home)
    for variable in ("AWS_SHARED_CREDENTIALS_FILE", "AWS_CONFIG_FILE"):
        monkeypatch.delenv(variable, raising=False)
    assert aws_profile() == {}
