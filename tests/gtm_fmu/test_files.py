"""What may be replaced by a file, and what is told about every other place."""

import os
import socket
import stat
from pathlib import Path

import pytest

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable, temporary_folder, writable_folder, write_whole

PLACES = {
    "pipe": r"is a pipe, which is not replaced; name an ordinary file\.",
    "socket": "is a socket, which is not replaced",
    "device": "is a device, which is not replaced",
    "link_to_device": "is a device, which is not replaced",
    "folder": r"is a folder; name a file in it\.",
    "link_to_folder": "is a folder",
    "link_to_itself": r"\(Too many levels of symbolic links\); choose a folder you may write to\.",
    "link_into_nowhere": r"Cannot write .*; choose a folder",
    "n" * 300: r"Cannot write .*nnn\.\.\.nnn.* \(File name too long\)",
    "/".join(["deep"] * 1000): r"Cannot write .*deep/.*\.\.\..*deep \(",
    "no/such/folder/file": r"Cannot write .* \(.*\); choose a folder",
    "file/below": r"\(Not a directory\)",
}


def make(folder: Path) -> None:
    """One of each kind."""
    os.mkfifo(folder / "pipe")
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(folder / "socket"))
    (folder / "folder").mkdir()
    (folder / "file").write_text("mine")
    for name in ("folder", "device", "file", "new"):
        (folder / f"link_to_{name}").symlink_to(folder / name)
    (folder / "link_to_itself").symlink_to(folder / "link_to_itself")
    (folder / "link_into_nowhere").symlink_to(folder / "none" / "of" / "it")


@pytest.fixture
def places(tmp_path, monkeypatch) -> Path:
    folder = tmp_path / "p"  # a short name: that of a socket has 107 letters at most
    folder.mkdir()
    monkeypatch.chdir(folder)
    make(Path())
    return folder


def kinds(folder: Path) -> dict[str, int]:
    return {path.name: stat.S_IFMT(path.lstat().st_mode) for path in folder.iterdir()}


def write(path: str | Path) -> None:
    write_whole(Path(path), lambda draft: draft.write_text("new"))


class TestPlaces:
    @pytest.mark.parametrize("place", PLACES)
    def test_nothing_but_a_file_is_replaced(self, places, place):
        if "device" in place:
            if os.geteuid():
                pytest.skip("only root makes devices")
            os.mknod(places / "device", stat.S_IFCHR | 0o600, os.makedev(1, 3))
        before = kinds(places)
        for attempt in (write, check_writable):
            with pytest.raises(InputError, match=PLACES[place]) as told:
                attempt(places / place)
            assert str(told.value).count("\n") == 0
            assert len(str(told.value)) < 400
        assert kinds(places) == before
        assert (places / "file").read_text() == "mine"

    @pytest.mark.parametrize("place", ["", ".", "..", "/"])
    def test_names_of_folders(self, places, place):
        for attempt in (write, check_writable):
            with pytest.raises(InputError, match="is a folder; name a file in it"):
                attempt(Path(place))

    @pytest.mark.parametrize("place", ["s3://bucket/a.csv", "https://example.org/a", "gs://b"])
    def test_addresses(self, places, place):
        before = kinds(places)
        for attempt in (write, check_writable, writable_folder):
            with pytest.raises(InputError, match="is an address; only files and folders of this machine are written"):
                attempt(Path(place))
        assert kinds(places) == before

    def test_a_folder_that_is_named_like_an_address(self, places):
        (places / "s3:").mkdir()
        write("s3:/file")
        assert (places / "s3:" / "file").read_text() == "new"

    @pytest.mark.parametrize("name", ["file", "new"])
    def test_a_link_stays_and_the_file_that_it_names_is_written(self, places, name):
        link = places / f"link_to_{name}"
        check_writable(link)
        write(link)
        assert link.is_symlink()
        assert (places / name).read_text() == "new"

    def test_permissions_stay(self, places):
        (places / "file").chmod(0o640)
        write("file")
        assert stat.S_IMODE((places / "file").stat().st_mode) == 0o640

    def test_a_file_that_may_not_be_written(self, places, monkeypatch):
        """As of a user: nothing is forbidden to root."""
        monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "file")
        with pytest.raises(InputError, match=r"Cannot write file \(Permission denied\)"):
            write("file")

    def test_the_longest_name(self, places):
        write("n" * 255)
        assert (places / ("n" * 255)).read_text() == "new"

    def test_only_one_folder_is_made(self, places):
        assert check_writable(places / "made" / "file") == places / "made" / "file"
        assert (places / "made").is_dir()
        with pytest.raises(InputError, match=r"no folder .*made/more"):
            check_writable(places / "made" / "more" / "still" / "file")
        assert not list((places / "made").iterdir())

    def test_folders(self, places):
        assert writable_folder("a/b/c").is_dir()
        assert writable_folder("link_to_folder").is_dir()
        for place in ("pipe", "socket", "file", "link_to_itself", "n" * 300, "/".join(["deep"] * 1000), "a/" * 1500):
            with pytest.raises(InputError, match=r"Cannot write .*; choose a folder"):
                writable_folder(place)
        assert kinds(places)["pipe"] == stat.S_IFIFO


def test_no_room_for_temporary_files():
    told = r"There is no room in the temporary folder '.*' \(No space left on device\): free some"
    with pytest.raises(InputError, match=told), temporary_folder():
        raise OSError(28, "No space left on device")
    with pytest.raises(FileNotFoundError), temporary_folder():
        raise FileNotFoundError
