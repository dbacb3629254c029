"""A page in headless Chromium, by the DevTools protocol over a pipe: nothing of the network is used."""

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import time

PROGRAMS = ('chromium', 'chromium-browser', 'google-chrome')
# Draws without a graphics card; a container's root has no sandbox.
OPTIONS = ('--headless', '--no-sandbox', '--disable-dev-shm-usage', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
           '--window-size=1100,700', '--remote-debugging-pipe')


def program():
    """The browser of this system; None where there is none."""
    return next((path for path in map(shutil.which, PROGRAMS) if path), None)


class Page:
    """One page; `errors` are the console's and what its scripts threw, `requests` all that it asked for."""

    def __init__(self, folder, url, deadline_s=60):
        self.deadline = time.monotonic() + deadline_s
        self.errors, self.requests, self.loaded, self.number, self.session = [], [], False, 0, None
        self.rest = b''
        down, self.write_end = os.pipe()
        self.read_end, up = os.pipe()
        # The browser reads from its descriptor 3 and writes to 4.
        self.process = subprocess.Popen(['bash', '-c', f'exec "$0" "$@" 3<&{down} 4>&{up}', program(), *OPTIONS,
                                         f'--user-data-dir={folder}/browser', 'about:blank'],
                                        pass_fds=(down, up), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(down)
        os.close(up)
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self.session = self.call('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(f'{domain}.enable')
        self.call('Network.emulateNetworkConditions', offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)
        self.call('Page.navigate', url=url)
        while not self.loaded:
            self._note(self._next())

    def close(self):
        with contextlib.suppress(OSError):
            os.close(self.write_end)
        self.process.kill()
        self.process.wait()
        os.close(self.read_end)

    def call(self, method, **parameters):
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters}
        if self.session:
            message['sessionId'] = self.session
        os.write(self.write_end, json.dumps(message).encode() + b'\0')
        while True:
            answer = self._next()
            if answer.get('id') == self.number:
                if 'error' in answer:
                    raise RuntimeError(f'{method}: {answer["error"]}')
                return answer['result']
            self._note(answer)

    def evaluate(self, script):
        """The value of an expression, also of a promise."""
        result = self.call('Runtime.evaluate', expression=script, awaitPromise=True, returnByValue=True)
        if 'exceptionDetails' in result:
            raise RuntimeError(result['exceptionDetails'])
        return result['result'].get('value')

    def picture(self):
        """What is shown, PNG in base64."""
        return self.call('Page.captureScreenshot', format='png')['data']

    def drag(self, start, end, steps=8):
        """The left button pressed at one place and released at another."""
        def mouse(kind, place, buttons):
            self.call('Input.dispatchMouseEvent', type=kind, x=place[0], y=place[1], button='left', buttons=buttons,
                      clickCount=1)
        mouse('mousePressed', start, 1)
        for step in range(1, steps + 1):
            mouse('mouseMoved', [a + (b - a) * step / steps for a, b in zip(start, end)], 1)
        mouse('mouseReleased', end, 0)

    def count(self, picture, condition):
        """How many pixels of a picture fulfil a condition on r, g and b; of its left part, without the words."""
        return self.evaluate('''(async () => {
            const image = new Image();
            image.src = 'data:image/png;base64,%s';
            await image.decode();
            const canvas = document.createElement('canvas');
            [canvas.width, canvas.height] = [Math.floor(0.6 * image.width), image.height];
            const context = canvas.getContext('2d');
            context.drawImage(image, 0, 0);
            const pixels = context.getImageData(0, 0, canvas.width, canvas.height).data;
            let count = 0;
            for (let i = 0; i < pixels.length; i += 4) {
                const [r, g, b] = pixels.slice(i, i + 3);
                count += %s ? 1 : 0;
            }
            return count;
        })()''' % (picture, condition))

    def _next(self):
        while b'\0' not in self.rest:
            left_s = self.deadline - time.monotonic()
            if left_s <= 0 or not select.select([self.read_end], [], [], left_s)[0]:
                raise TimeoutError('the browser did not answer')
            more = os.read(self.read_end, 1 << 16)
            if not more:
                raise EOFError('the browser has ended')
            self.rest += more
        message, self.rest = self.rest.split(b'\0', 1)
        return json.loads(message)

    def _note(self, event):
        method, content = event.get('method'), event.get('params', {})
        if method == 'Runtime.exceptionThrown':
            self.errors.append(content['exceptionDetails'])
        elif method == 'Runtime.consoleAPICalled' and content['type'] in ('error', 'warning', 'assert'):
            self.errors.append(content['args'])
        elif method == 'Log.entryAdded' and content['entry']['level'] == 'error':
            self.errors.append(content['entry'])
        elif method == 'Network.requestWillBeSent':
            self.requests.append(content['request']['url'])
        elif method == 'Page.loadEventFired':
            self.loaded = True


def save(picture, path):
    """Writes a picture to look at."""
    path.write_bytes(base64.b64decode(picture))
