# SPDX-License-Identifier: Apache-2.0
"""Servers on loopback for the tests of `orthodrive fetch`: tiles and files with ranges, and a proxy that injects
faults.
"""

import contextlib
import functools
import hashlib
import http.client
import http.server
import io
import math
import random
import re
import socket
import threading
import time
import urllib.parse

import numpy
import PIL.Image

HALF = 20037508.342789244


def mercator(lon, lat):
    return HALF * lon / 180.0, HALF * math.log(math.tan(math.pi / 4 + math.radians(lat) / 2)) / math.pi


def picture(east, north):
    """Red, green, blue of a made-up ground at web mercator metres: waves of 8 m and longer, no two places alike."""
    r = 128 + 60 * numpy.sin(east / 9.0) * numpy.cos(north / 13.0) + 50 * numpy.sin((east + 2 * north) / 70.0)
    g = 128 + 60 * numpy.sin((east - north) / 11.0) + 50 * numpy.cos(north / 50.0)
    b = 128 + 50 * numpy.sin((east + north) / 15.0) + 60 * numpy.sin(east / 90.0)
    return numpy.clip(numpy.stack([r, g, b], axis=-1), 0, 255).astype(numpy.uint8)


def tile_pixels(z, x, y, size=256):
    resolution = 2 * HALF / size / 2**z
    east = -HALF + (x * size + numpy.arange(size) + 0.5) * resolution
    north = HALF - (y * size + numpy.arange(size) + 0.5) * resolution
    return picture(*numpy.meshgrid(east, north))


def encoded(pixels, form="JPEG"):
    out = io.BytesIO()
    PIL.Image.fromarray(pixels).save(out, form, **({"quality": 92} if form == "JPEG" else {}))
    return out.getvalue()


@functools.cache  # most tests look at the same place
def tile(z, x, y, form="JPEG", dark=False):
    pixels = tile_pixels(z, x, y)
    return encoded(pixels // 2 if dark else pixels, form)


class Server:
    """answer(method, path, headers, body) gives (status, headers, body), or a function that gets the handler and does
    it itself.
    """

    def __init__(self, answer):
        outer = self
        self.log, self.lock = [], threading.Lock()

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
                reply = answer(self.command, self.path, self.headers, body)
                with outer.lock:
                    outer.log.append(
                        (
                            self.path,
                            reply[0] if isinstance(reply, tuple) else 0,
                            {**self.headers, "method": self.command},
                        )
                    )
                if callable(reply):
                    return reply(self)
                status, headers, content = reply
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                if "Content-Length" not in headers:
                    self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                if self.command != "HEAD":
                    self.wfile.write(content)
                return None

            do_POST = do_HEAD = do_GET  # noqa: N815 (names that http.server asks for)

            def log_message(self, *_):
                pass

            def handle_one_request(self):
                try:
                    super().handle_one_request()
                except OSError:
                    self.close_connection = True

        class Threads(http.server.ThreadingHTTPServer):
            daemon_threads = True

            def handle_error(self, *_):  # a client that was killed
                pass

        self.server = Threads(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}"
        threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()

    def paths(self):
        with self.lock:
            return [entry[0] for entry in self.log]

    def close(self):
        self.server.shutdown()
        self.server.server_close()


def etag(content):
    return '"' + hashlib.md5(content).hexdigest() + '"'


def conditional(content, kind, headers):
    tag = etag(content)
    if headers.get("If-None-Match") == tag:
        return 304, {"ETag": tag}, b""
    return 200, {"Content-Type": kind, "ETag": tag}, content


def tile_origin(form="JPEG", absent=lambda z, x, y: False, changed=None, delay_s=0.0):
    """/ANYTHING/{z}/{x}/{y}.jpg; `changed` is a set of (z, x, y) that are drawn darker from now on."""

    def answer(method, path, headers, body):
        found = re.search(r"/(\d+)/(\d+)/(\d+)\.(?:jpg|png)", path)
        if not found:
            return 404, {}, b"no such page"
        key = tuple(map(int, found.groups()))
        time.sleep(delay_s)
        if absent(*key):
            return 404, {"Content-Type": "text/html"}, b"<html>not here</html>"
        dark = bool(changed and key in changed)
        return conditional(tile(*key, form, dark), "image/" + form.lower(), headers)

    return Server(answer)


def file_origin(files, cut_after=None):
    """Whole files and single ranges (RFC 9110). `cut_after`: connections break after so many bytes of a body."""

    def answer(method, path, headers, body):
        content = files.get(urllib.parse.urlparse(path).path)
        if content is None:
            return 404, {}, b"no such file"
        tag = etag(content)
        found = re.fullmatch(r"bytes=(\d+)-(\d*)", headers.get("Range") or "")
        if headers.get("If-None-Match") == tag:
            return 304, {"ETag": tag}, b""
        status, first, last = 200, 0, len(content) - 1
        if found and headers.get("If-Range", tag) == tag:
            first, last = int(found[1]), min(last, int(found[2] or last))
            if first > last:
                return 416, {"Content-Range": f"bytes */{len(content)}"}, b""
            status = 206
        part = content[first : last + 1]
        fields = {"ETag": tag, "Accept-Ranges": "bytes", "Content-Type": "application/octet-stream"}
        if status == 206:
            fields["Content-Range"] = f"bytes {first}-{last}/{len(content)}"
        if cut_after is None or len(part) <= cut_after or method == "HEAD":
            return status, fields, part

        def cut(handler):
            handler.send_response(status)
            for name, value in {**fields, "Content-Length": str(len(part))}.items():
                handler.send_header(name, value)
            handler.end_headers()
            handler.wfile.write(part[:cut_after])
            handler.close_connection = True

        return cut

    return Server(answer)


FAULTS = [
    "404",
    "429",
    "429 date",
    "500",
    "503",
    "truncated",
    "short",
    "corrupt",
    "slow",
    "cut",
    "html",
    "redirect",
    "loop",
]


class FaultProxy(Server):
    """Passes requests on to `origin`. A share of them gets a fault instead, by the seed, the path and how often it was
    asked.
    """

    def __init__(self, origin, share, seed=1, faults=FAULTS):
        self.asked, self.done, self.delivered = {}, {}, {}
        parts = urllib.parse.urlparse(origin.url)

        def forward(path, headers):
            connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=30)
            kept = {
                k: v
                for k, v in headers.items()
                if k.lower() in ("range", "if-range", "if-none-match", "if-modified-since")
            }
            connection.request("GET", path, headers=kept)
            reply = connection.getresponse()
            fields = {
                k: v
                for k, v in reply.getheaders()
                if k.lower() not in ("connection", "server", "date", "content-length")
            }
            content = reply.read()
            connection.close()
            return reply.status, fields, content

        def answer(method, path, headers, body):
            with self.lock:
                self.asked[path] = self.asked.get(path, 0) + 1
                draw = random.Random(f"{seed} {path} {self.asked[path]}")
                fault = draw.choice(faults) if draw.random() < share else None
                if fault:
                    self.done[fault] = self.done.get(fault, 0) + 1
            if fault is None:
                reply = forward(path, headers)
                with self.lock:
                    self.delivered[path] = self.delivered.get(path, 0) + 1
                return reply
            return self.broken(fault, path, headers, forward)

        self.forward = forward
        super().__init__(answer)

    def broken(self, fault, path, headers, forward):
        if fault in ("404", "500", "503"):
            return int(fault), {"Content-Type": "text/html"}, b"<html>fault</html>"
        if fault == "429":
            return 429, {"Retry-After": "1"}, b""
        if fault == "429 date":
            return 429, {"Retry-After": time.strftime("%a, %d %b %Y %H:%M:%S GMT", time.gmtime(time.time() + 1))}, b""
        if fault == "html":
            return 200, {"Content-Type": "text/html"}, b"<!DOCTYPE html><html>Please log in</html>"
        if fault == "redirect":
            return 302, {"Location": path + ("&" if "?" in path else "?") + "hop=1"}, b"<html>moved</html>"
        if fault == "loop":
            return 302, {"Location": path}, b""
        status, fields, content = forward(path, headers)
        half = len(content) // 2
        if fault == "short":  # a whole answer of half a picture
            return status, fields, content[:half]
        if fault == "corrupt":
            return (
                status,
                fields,
                content[:half] + bytes(64) + b"\xff\xd9" + content[half + 66 :] if half > 200 else b"x" * len(content),
            )

        def cut(handler):
            if fault != "cut":
                handler.send_response(status)
                for name, value in {**fields, "Content-Length": str(len(content))}.items():
                    handler.send_header(name, value)
                handler.end_headers()
            if fault == "truncated":
                handler.wfile.write(content[:half])
            if fault == "slow":  # slow, but it comes
                for at in range(0, len(content), 4000):
                    handler.wfile.write(content[at : at + 4000])
                    handler.wfile.flush()
                    time.sleep(0.05)
                return
            handler.close_connection = True
            with contextlib.suppress(OSError):
                handler.connection.shutdown(socket.SHUT_RDWR)

        return cut
