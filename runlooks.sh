cd /tmp/w/h44e; date; nice -n 5 /tmp/w/capenv-h44/bin/python looks2.py hardlooks b,f,bm,fm,p,fn,z,u $(python3 -c "
import json; print(' '.join('hard/%03d.mp4'%n for n in json.load(open('sel.json'))))") 2>looks.err; date
