"""Speech in other languages with exact starts of words: eSpeak NG's formants, MBROLA's diphones, prompts recorded by people.

The latter two are Debian packages: mbrola, mbrola-de6 (and others) with espeak-ng; asterisk-core-sounds-es-wav (and others).
"""

import difflib
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from s2ag.core.sound import audio

SHARE = Path(os.environ.get("S2AG_SHARE", "/usr/share"))
"""Where Debian's packages put their data."""
MBROLA = SHARE / "mbrola"
TEXTS = {
    "de": """
Guten Abend und herzlich willkommen, meine Damen und Herren. Ich möchte Ihnen heute erzählen, wie wir im letzten
Sommer über die Berge gewandert sind. Zuerst dachten wir, das Wetter würde halten, aber schon am zweiten Tag kam ein
schweres Gewitter. Wir fanden Schutz in einer kleinen Hütte, in der ein alter Schäfer mit seinen Hunden lebte. Er
kochte uns eine kräftige Suppe und sprach sehr langsam, damit wir ihn verstehen konnten. Früher, sagte er, gab es
hier oben viel mehr Schnee. Heute bleibt kaum noch etwas davon übrig, wenn der Frühling kommt. Meine Schwester
fragte ihn, ob er nicht einsam sei. Da lachte er laut und zeigte auf die Tiere vor der Tür. Am nächsten Morgen war
der Himmel wieder klar, und die Gipfel leuchteten in der Sonne. Wir verabschiedeten uns und stiegen durch den Wald
hinunter ins Tal. Unterwegs sammelten wir Pilze, Beeren und glatte Steine aus dem Bach. Natürlich wurden unsere
Schuhe nass, doch das störte niemanden. Im Dorf gab es frisches Brot, Käse, Äpfel und heiße Schokolade. Ich glaube,
dass solche Tage wichtiger sind als alles, was man kaufen kann. Vielleicht gehen Sie selbst einmal dorthin. Nehmen
Sie sich Zeit, hören Sie zu, und vergessen Sie für eine Weile Ihr Telefon. Vielen Dank für Ihre Aufmerksamkeit, und
kommen Sie gut nach Hause.
""",
    "es": """
Buenas noches y bienvenidos a todos. Quiero contarles hoy cómo cruzamos las montañas el verano pasado. Al principio
creíamos que haría buen tiempo, pero el segundo día llegó una tormenta muy fuerte. Encontramos refugio en una casa
pequeña donde vivía un viejo pastor con sus perros. Nos preparó una sopa caliente y hablaba despacio para que
pudiéramos entenderle. Antes, nos dijo, había mucha más nieve por aquí. Mi hermana le preguntó si no se sentía solo.
Entonces se rió y señaló los animales delante de la puerta. A la mañana siguiente el cielo estaba claro y las
cumbres brillaban bajo el sol. Bajamos por el bosque hasta el valle y recogimos setas, moras y piedras lisas del
río. En el pueblo había pan fresco, queso, manzanas y chocolate caliente. Creo que días como esos son más
importantes que todo lo que se puede comprar. Muchas gracias por su atención.
""",
    "fr": """
Bonsoir et bienvenue à tous. Je voudrais vous raconter comment nous avons traversé les montagnes pendant le dernier
été. Au début, nous pensions que le temps resterait beau, mais le deuxième jour un gros orage est arrivé. Nous avons
trouvé refuge dans une petite maison où vivait un vieux berger avec ses chiens. Il nous a préparé une bonne soupe et
parlait lentement pour que nous puissions le comprendre. Autrefois, disait il, il y avait beaucoup plus de neige. Ma
soeur lui a demandé si la solitude ne lui pesait pas. Alors il a ri et montré les bêtes devant sa porte. Le
lendemain matin, le ciel était clair et les sommets brillaient au soleil. Nous sommes descendus par la forêt jusque
dans la vallée. Dans le village il y avait du pain frais, du fromage, des pommes et du chocolat chaud. Merci
beaucoup pour votre attention.
""",
}


def formants(language, text, folder):
    """Sound ``(n,)`` at 16 kHz, and ``[word, start]`` of every word."""
    command = [sys.executable, Path(__file__).with_name("espeak_voice.py"), language, folder / "said.wav"]
    done = subprocess.run(command, input=" ".join(text.split()).encode(), stdout=subprocess.PIPE, check=True)
    return audio.load(folder / "said.wav"), json.loads(done.stdout)


def has_diphones(voice):
    """Whether the programs and this voice are here."""
    return bool(shutil.which("mbrola") and shutil.which("espeak-ng") and (MBROLA / voice / voice).is_file())


def diphones(voice, text, folder):
    """The same; starts of words that eSpeak NG says otherwise in a sentence than alone are None."""
    words = [plain(word) for word in text.split()]
    lines = _phones(voice, " ".join(text.split()))
    (folder / "said.pho").write_text("".join(line + "\n" for line in lines), encoding="utf-8")
    command = ["mbrola", "-e", MBROLA / voice / voice, folder / "said.pho", folder / "said.wav"]
    subprocess.run(command, check=True, capture_output=True)
    names, lengths = [line.split()[0] for line in lines], [int(line.split()[1]) / 1000 for line in lines]
    times = np.cumsum([0.0, *lengths])
    said = [place for place, name in enumerate(names) if name != "_"]
    alone = [[line.split()[0] for line in _phones(voice, word) if line[0] != "_"] for word in words]
    firsts = np.cumsum([0, *map(len, alone)])
    pairs = difflib.SequenceMatcher(None, sum(alone, []), [names[place] for place in said], autojunk=False)
    where = {block.a + k: block.b + k for block in pairs.get_matching_blocks() for k in range(block.size)}
    found = []
    for word, first in zip(words, firsts.tolist(), strict=False):
        here, before = where.get(first), where.get(first - 1)
        sure = here is not None and (before is None or before == here - 1)
        found.append([word, float(times[said[here]]) if sure else None])
    return audio.load(folder / "said.wav"), found


def prompts(language, count=150):
    """Prompts for telephones, joined in a fixed order: starts of first words by the sound's energy, all others None."""
    texts = SHARE / "doc" / f"asterisk-core-sounds-{language}" / f"core-sounds-{language}.txt.gz"
    folder = next((SHARE / "asterisk" / "sounds").glob(f"{language}_*"))
    lines = re.findall(r"^([^;:\s]+): *(.+)$", gzip.decompress(texts.read_bytes()).decode(), re.MULTILINE)
    odd = re.compile(r"[\[(<0-9&=*#]|\bm\.|letters|phonetic|silence|beep")
    chosen = [(said, folder / f"{name}.wav") for name, said in lines if (folder / f"{name}.wav").is_file()]
    chosen = [(said, path) for said, path in chosen if not odd.search(said + path.stem) and len(said.split()) <= 12]
    draw, pieces, found, time = np.random.default_rng(0), [], [], 0.0
    for number in draw.permutation(len(chosen))[:count]:
        said, path = chosen[number]
        sound = _trimmed(audio.load(path))
        gap = np.zeros(int(audio.SAMPLE_RATE * (0.5 if len(pieces) % 10 == 8 else draw.uniform(0.04, 0.12))))
        found += [[plain(word), None if place else time] for place, word in enumerate(said.split()) if plain(word)]
        pieces += [sound, gap]
        time += (len(sound) + len(gap)) / audio.SAMPLE_RATE
    joined = np.concatenate(pieces)
    return (joined + draw.normal(0, 1e-4, len(joined))).astype(np.float32), found


def plain(word):
    """The word without punctuation around it."""
    return re.sub(r"^\W+|\W+$", "", word)


def _phones(voice, text):
    """Lines of MBROLA's: phone, milliseconds, pitch."""
    command = ["espeak-ng", "-v", f"mb-{voice}", "-s", "160", "-q", "--pho", text]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    return [line.strip() for line in lines if line.strip() and line[0] != ";"]


def _trimmed(sound):
    """Without silence around it."""
    power = np.convolve(sound**2, np.ones(160) / 160, mode="same")
    loud = np.flatnonzero(power > max(power.max() * 10**-3.6, 1e-7))
    return sound[loud[0] : loud[-1] + 1]
