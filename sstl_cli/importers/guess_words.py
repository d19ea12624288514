"""Words that loggers put into channel names, in five European languages, Chinese, Japanese and Korean, and what they mean."""

from __future__ import annotations

import re
import unicodedata

# V DC, Vdc, mVDC, V(AC): volts, of whatever kind
_VOLTS = re.compile(r"(?<![^\W\d_])([mkuµμ]?)(?:V[ _]?(?:\((?:DC|AC)\)|(?:DC|AC))|(?:DC|AC)[ _]?V)(?![^\W\d_])", re.IGNORECASE)


def unaccented(text: str) -> str:
    """Return a text without its accents.

    Examples
    --------
    >>> unaccented("Krümmung")
    'Krummung'
    """
    return "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))


def as_volts(text: str) -> str:
    """Return a text in which volts of direct or alternating voltage are V.

    Examples
    --------
    >>> [as_volts(t) for t in ("Fin (VDC)", "Fout_Vdc", "101 <F> (V DC)", "mV DC", "vacuum")]
    ['Fin (V)', 'Fout_V', '101 <F> (V)', 'mV', 'vacuum']
    """
    return _VOLTS.sub(r"\1V", text)


def words(text: str) -> frozenset[str]:
    """Return the words of a text."""
    return frozenset(text.split())


# what a channel measures; the first that is found in this order counts
QUANTITY: dict[str, str] = {
    "current": "current curr strom courant corriente corrente amp amps ampere",
    "other": (
        "voltage volts temp temperature temperatur temperatura vel velocity speed geschwindigkeit vitesse velocidad "
        "velocita acc accel acceleration beschleunigung torque moment drehmoment couple coppia pwm duty valve flow "
        "error err fehler erreur status state flag mode power battery humidity vibration vibrations vib schwingung gain strain dehnung emg imu gyro "
        "residual cpu latency delay quality rssi loss losses delta diff difference deviation friction "
        "verlust reibung differenz abweichung perte frottement ecart perdida friccion attrito"
    ),
    "pressure": "pressure druck pression presion pressione",
    "force": (
        "force forces frc tension tensions tens tensile load loads loadcell lc cell newton newtons kraft zugkraft zug "
        "seilkraft fuerza fuerzas carga tensione forza forze carico tiro traction traccion trazione forca kracht trekkracht weight gewicht poids peso hx wrench ft fx fy fz"
    ),
    "position": (
        "position pos displacement displ disp stroke travel extension elongation weg hub pfad verschiebung course "
        "deplacement posicion recorrido desplazamiento carrera corsa spostamento posizione encoder enc lvdt length"
    ),
    "angle": "angle winkel angolo angulo rotation rot theta heading joint",
    "time": (
        "time times t zeit zeitstempel uhrzeit temps tiempo tempo stamp timestamp clock elapsed secs sec second "
        "seconds sekunden segundos secondi secondes millis micros nanos msec usec nsec nsecs tout hora heure date "
        "datetime datum fecha horodatage duree messzeit"
    ),
    "index": (
        "index idx sample samples nr no num number n row line frame seq sequence counter count cnt messung messwert "
        "punkt point scan i id lfd zeile numero muestra echantillon campione unnamed"
    ),
}
SIDE: dict[str, str] = {
    "in": (
        "in inp input prox proximal motor drive driver driving actuator actuation source upstream base handle winch "
        "pull pulling antrieb actuador actionneur attuatore eingang eingangs ein entree entrada ingresso moteur motore amont proximale prossimale servo ingang "
        "motorside driveside actuatorside proximalside inputside motorseite antriebsseite"
    ),
    "out": (
        "out outp output dist distal tip end effector downstream remote tool gripper return driven abtrieb ausgang "
        "ausgangs aus endeffektor extremite spitze ende sortie salida uscita distale saida uitgang extremo aval punta jaw "
        "tipside loadside toolside distalside outputside lastseite abtriebsseite"
    ),
}
REFERENCE = words(
    "ref reference cmd command commanded desired des setpoint set sp target soll sollwert consigne consigna "
    "referencia riferimento demand goal nominal vorgabe gewenst gewenste desiderata desiderato objetivo deseada deseado demande demandee "
    "voulu voulue richiesta richiesto"
)
# of a channel that was planned, computed or taken of readings, or that tells something about the one that was measured
NOT_MEASURED = words(
    "requested planned theoretical theory theoretisch theorique teorica teorico calc calculated calculee calculada berechnet "
    "estimate estimated est estimee estimada estimado geschatzt hat observer ideal limit threshold preload offset tare noise "
    "uncertainty resolution std var variance max maximum min minimum peak pred predicted prediction fem expected sim simulated "
    "simulation simuliert simulee simulada computed virtual capstan controller pid amplifier filter saturation stiffness normal lateral shear contact pretension "
    "log10 model modell modele modelo fit fitted fft trajectory rate prev kf kalman nn mv abs sum "
    "crete pic pico picco spitzenwert scheitelwert dot derivative deriv derivee derivada derivata ableitung"
)
# no force at a moment, and of one sensor no more derived than its mean
RMS = words("rms effektivwert efficace")
# of how readings were treated, which tells several of one sensor apart
TREATED = NOT_MEASURED | RMS | words("raw filtered filt smoothed smooth mean avg average median corrected uncorrected zeroed tared")
# parts of German compounds and of words written together
STEMS: dict[str, tuple[str, str]] = {
    "kraft": ("quantity", "force"),
    "tension": ("quantity", "force"),
    "force": ("quantity", "force"),
    "load": ("quantity", "force"),
    "eingang": ("side", "in"),
    "antrieb": ("side", "in"),
    "input": ("side", "in"),
    "motor": ("side", "in"),
    "prox": ("side", "in"),
    "ausgang": ("side", "out"),
    "abtrieb": ("side", "out"),
    "output": ("side", "out"),
    "dist": ("side", "out"),
    "lastseit": ("side", "out"),
    "endeffektor": ("side", "out"),
    "zeit": ("quantity", "time"),
    "time": ("quantity", "time"),
    "soll": ("reference", "reference"),
    "winkel": ("quantity", "angle"),
    "strom": ("quantity", "current"),
    "druck": ("quantity", "pressure"),
}
QUANTITY_OF = {word: kind for kind, words in reversed(QUANTITY.items()) for word in words.split()}
SIDE_OF = {word: side for side, words in SIDE.items() for word in words.split()}
# written by loggers in other ways than the unit's own name
UNIT_WORDS = {
    "newton": "N",
    "newtons": "N",
    "millis": "ms",
    "millisecond": "ms",
    "milliseconds": "ms",
    "millisekunden": "ms",
    "msec": "ms",
    "msecs": "ms",
    "micros": "us",
    "microseconds": "us",
    "usec": "us",
    "usecs": "us",
    "nanos": "ns",
    "nsec": "ns",
    "nsecs": "ns",
    "nanoseconds": "ns",
    "secs": "s",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "sekunden": "s",
    "segundos": "s",
    "secondes": "s",
    "secondi": "s",
    "sek": "s",
    "seg": "s",
    "minuten": "min",
    "mins": "min",
    "minuto": "min",
    "minutos": "min",
    "minuti": "min",
    "volt": "V",
    "volts": "V",
    "grad": "deg",
    "grados": "deg",
    "gradi": "deg",
    "degres": "deg",
    "raw": "counts",
    "adc": "counts",
    "count": "counts",
    "cts": "counts",
    "digit": "counts",
    "digits": "counts",
    "lsb": "counts",
    "bits": "counts",
    "kp": "kgf",
    "pounds": "lbf",
    "grams": "gf",
    "gram": "gf",
    "gramm": "gf",
    "gramme": "gf",
    "grammes": "gf",
    "gramos": "gf",
    "grammi": "gf",
    "с": "s",
    "сек": "s",
    "мс": "ms",
    "мкс": "us",
    "н": "N",
    "мн": "mN",
    "кн": "kN",
    "гс": "gf",
    "кгс": "kgf",
}
# units of mass that a dash or a blank turns into one of force: kg-f, pound force
_OF_FORCE = {
    "gf": "g gram grams gramme grammes",
    "kgf": "kg kilogram kilograms kilogramme",
    "lbf": "lb lbs pound pounds",
    "ozf": "oz ounce ounces",
}
# in brackets or a row of units, where a word can only be a unit: in other letters than its own
UNIT_CELLS = UNIT_WORDS | {
    **{u: u for u in ("s", "ms", "us", "ns", "min", "h", "kgf", "gf", "lbf", "ozf")},
    "hr": "h",
    "hrs": "h",
    "std": "h",
    "kg": "kgf",
    "lb": "lbf",
    "lbs": "lbf",
    "pound": "lbf",
    "ounce": "ozf",
    "ounces": "ozf",
    "oz": "ozf",
    "gmf": "gf",
    "grf": "gf",
    "kn": "kN",
    "cn": "cN",
    "dn": "dN",
    "dan": "daN",
    "centinewton": "cN",
    "decinewton": "dN",
    "decanewton": "daN",
    "dekanewton": "daN",
    "millinewton": "mN",
    "kilonewton": "kN",
    "micronewton": "uN",
    "kilopond": "kgf",
    "pond": "gf",
    "dyn": "dyn",
    "dyne": "dyn",
    "dynes": "dyn",
    "牛": "N",
    "毫牛": "mN",
    "千牛": "kN",
    "克力": "gf",
    "千克力": "kgf",
    "公斤力": "kgf",
    **{
        f"{word}{mark}{force}": unit
        for unit, many in _OF_FORCE.items()
        for word in many.split()
        for mark in "- "
        for force in ("f", "force")
    },
}
# of a time that does not go on in a unit of time, or is none
NO_CLOCK = words(
    "cycle cycles normalized normalised norm normiert frame frames fraction ratio phase period periode step steps timestep sqrt"
)
# of a screw that bends the tube: how far it is turned in, in names of files and of columns
LEAD = words("lead screw leadscrew spindel")
# in a name whose unit is a length: what is moved, or how far, and what is only measured along
PLACED = words(QUANTITY["position"]) - {"length"} | words(
    "motor drive driver actuator servo winch moteur actionneur motore attuatore actuador antrieb slider slide carriage crosshead stage schlitten traverse"
)
PLACED_STEMS = ("position", "posicion", "posizion", "displace", "verschieb", "stroke", "weg", "hub", "motor", "antrieb")
DIMENSIONS = words(
    "gap diameter dia radius thickness width height depth durchmesser spalt dicke breite hoehe diametre rayon epaisseur largeur "
    "diametro raggio spessore larghezza radio grosor espesor ancho"
)
# units of something else, which no sensor's gain turns into a tension
ELSE = words("a ma mw nm ncm nmm mnm knm degc degf degk celsius rpm hz")
# of a load cell read as a ratio
BRIDGE = words("mv/v uv/v v/v")
# units that are no force, and that no factor known here turns into one
STRANGE = ELSE | BRIDGE | words("% percent pct prozent fs au arb norm pu")
# of Chinese, Japanese and Korean, which write no blanks: the longest first; of Russian the beginnings of words
SIGNS = {
    "输入": "input", "入力": "input", "近端": "proximal", "输出": "output", "出力": "output", "远端": "distal", "遠端": "distal",
    "时间": "time", "時間": "time", "時刻": "time", "序号": "index", "番号": "index", "拉力": "tension", "张力": "tension", "張力": "tension",
    "位移": "displacement", "位置": "position", "위치": "position", "行程": "stroke", "ストローク": "stroke", "스트로크": "stroke",
    "变位": "displacement", "変位": "displacement", "目标": "target", "目標": "target", "指令": "command",
    "荷重": "load", "モータ": "motor", "電流": "current", "电流": "current", "電圧": "voltage", "电压": "voltage", "温度": "temperature",
    "輸入": "input", "輸出": "output", "近側": "proximal", "遠側": "distal", "電機": "motor", "电机": "motor",
    "시간": "time", "입력": "input", "출력": "output", "장력": "tension", "하중": "load", "모터": "motor", "변위": "displacement",
    "推定": "estimate", "估计": "estimate", "仿真": "simulated", "計算": "computed", "理論": "theory",
    "设定": "setpoint", "設定": "setpoint", "给定": "setpoint", "期望": "desired", "설정": "setpoint", "목표": "target", "지령": "command",
    "峰值": "peak", "ピーク": "peak", "最大": "max", "最小": "min", "微分": "derivative", "均方根": "rms", "有效值": "rms", "実効値": "rms",
    "上午": "am", "午前": "am", "오전": "am", "下午": "pm", "午後": "pm", "午后": "pm", "오후": "pm",
    "力": "force",
    "время": "time", "времен": "time", "отсчет": "sample", "номер": "number", "натяжени": "tension", "усили": "force", "сила": "force", "силы": "force",
    "нагрузк": "load", "выход": "output", "вход": "input", "дистальн": "distal", "проксимальн": "proximal", "двигател": "motor", "привод": "drive",
    "перемещени": "displacement", "положени": "position", "задан": "setpoint", "расчетн": "computed", "температур": "temperature",
    "напряжени": "voltage", "скорост": "velocity", "момент": "torque", "давлени": "pressure", "угол": "angle",
}  # fmt: skip


def lowered(text: str) -> str:
    """Return a text with its Cyrillic letters small, as the words of ``SIGNS`` are.

    Examples
    --------
    >>> lowered("Время F_in")
    'время F_in'
    """
    return text if text.isascii() else re.sub("[\u0400-\u04ff]+", lambda m: m[0].lower(), text)
