// Haptic tracing by itself: the graph of what touches, best paths, mix. What touches and what hits is told by the engine.
// One file for .NET Standard 2.0 (Unity 2021 and later), without dependencies; a step allocates nothing once it has run.
// The tables are those of NAME.tracer.json (docs/tracer.md), or are made in code.

using System;
using System.Collections.Generic;
using System.Globalization;
using System.Text;

namespace HapticTracer
{
    public struct Vector
    {
        public double X, Y, Z;

        public Vector(double x, double y, double z) { X = x; Y = y; Z = z; }

        public double Length { get { return Math.Sqrt(Dot(this)); } }
        public double Dot(Vector v) { return X * v.X + Y * v.Y + Z * v.Z; }
        public Vector Cross(Vector v) { return new Vector(Y * v.Z - Z * v.Y, Z * v.X - X * v.Z, X * v.Y - Y * v.X); }
        public static Vector operator +(Vector a, Vector b) { return new Vector(a.X + b.X, a.Y + b.Y, a.Z + b.Z); }
        public static Vector operator -(Vector a, Vector b) { return new Vector(a.X - b.X, a.Y - b.Y, a.Z - b.Z); }
        public static Vector operator *(Vector v, double factor) { return new Vector(v.X * factor, v.Y * factor, v.Z * factor); }
    }

    /// <summary>What a connection costs, -log of its gain, in each lane: without bands, then by band if there are any.</summary>
    public sealed class Function
    {
        internal double[] Loss, Decay, Grid, Costs, Spring;
        internal double Exponent, Reference = 1, Extent = 1, Width = 1, Over, Point = double.PositiveInfinity, Range, Slowness;
        internal string Variable;

        public Function(double loss, double decay, int lanes = 1)
        {
            Loss = new double[lanes];
            Decay = new double[lanes];
            for (var lane = 0; lane < lanes; lane++) { Loss[lane] = loss; Decay[lane] = decay; }
        }

        internal Function() { }

        /// <summary>K exp(-max(K, epsilon) d) with K = (1 - kappa) rho.</summary>
        public static Function Paper(double kappa, double rho, int lanes = 1)
        {
            var k = (1 - kappa) * rho;
            return new Function(-Math.Log(k), Math.Max(k, 0.1), lanes);
        }

        /// <summary>Of another form than a metric plus a constant, so that an object may be entered again at any cost.</summary>
        internal bool IsSpecial { get { return Range > 0 || Costs != null; } }

        internal double Spread(double run)
        {
            if (Exponent == 0) return 0;
            return run > Extent
                ? Exponent * Math.Log(1 + Extent / Reference) + 0.5 * Math.Log(1 + (run - Extent) / Width)
                : Exponent * Math.Log(1 + run / Reference);
        }

        /// <summary>What is alike in all lanes over a distance between fronts of waves that have run some way before.</summary>
        internal double Shape(double distance, double value, double one, double other, double halves)
        {
            var cost = one == 0 && other == 0
                ? Spread(distance < Over ? distance : Over)
                : Math.Max(Spread(Math.Max(Math.Max(one, other), Math.Min(distance + (one + other) / 2, Over))) - halves, 0);
            return IsSpecial ? cost + Special(distance, value) : cost;
        }

        double Special(double distance, double value)
        {
            var cost = Range == 0 ? 0 : distance < Range ? -Math.Log(1 - distance / Range) : double.PositiveInfinity;
            if (Costs == null || double.IsNaN(value)) return cost;
            var place = Array.BinarySearch(Grid, value);
            if (place < 0) place = Math.Min(~place, Grid.Length - 1);
            if (place == 0) return cost + Costs[0];
            var share = (Math.Min(value, Grid[place]) - Grid[place - 1]) / (Grid[place] - Grid[place - 1]);
            var sampled = Costs[place - 1] + share * (Costs[place] - Costs[place - 1]);
            return sampled < 14 ? cost + sampled : double.PositiveInfinity;
        }
    }

    /// <summary>A body by whose impedance contacts pass on. Its arrays are by frequency band.</summary>
    sealed class Body
    {
        internal int Kind;
        internal double[] Mobility, Bending, HalfSpace, Spring;

        internal bool Carries { get { return Bending != null || Spring != null; } }

        /// <summary>The mobility of a half-space under a patch.</summary>
        internal double At(double omega, double area)
        {
            var driven = HalfSpace[0] + area / Math.PI;
            double damper = HalfSpace[2] * driven, spring = HalfSpace[1] * Math.Sqrt(driven) / omega;
            return 1 / Math.Sqrt(damper * damper + spring * spring);
        }
    }

    /// <summary>An object that vibration runs through.</summary>
    public sealed class TracedObject
    {
        public string Name;
        public Function Function;
        /// <summary>Its class in the tables of contacts and blows, and its mass in kilograms, 0 if nothing moves it.</summary>
        public int Class;
        public double Mass;
        internal Body Body;
        internal Vector Centre = new Vector(double.NaN, 0, 0), Size = new Vector(double.NaN, 0, 0), Place;
        internal Vector X = new Vector(1, 0, 0), Y = new Vector(0, 1, 0), Z = new Vector(0, 0, 1);
        /// <summary>Whether it moves with what stands behind it, and in which rounds that changes: bits.</summary>
        internal bool Carries;
        internal int Due;

        /// <summary>Where it is: position and rotation.</summary>
        public void Move(double x, double y, double z, double qw, double qx, double qy, double qz)
        {
            Place = new Vector(x, y, z);
            X = new Vector(1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz), 2 * (qx * qz - qw * qy));
            Y = new Vector(2 * (qx * qy - qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qw * qx));
            Z = new Vector(2 * (qx * qz + qw * qy), 2 * (qy * qz - qw * qx), 1 - 2 * (qx * qx + qy * qy));
        }

        /// <summary>What a patch with this normal fills per area: the inverse of its width.</summary>
        internal double Across(Vector normal)
        {
            if (double.IsNaN(Size.X)) return 0;
            double a = normal.Dot(X), b = normal.Dot(Y), c = normal.Dot(Z);
            return a * a / Math.Max(Math.Min(Size.Y, Size.Z), 0.01) + b * b / Math.Max(Math.Min(Size.Z, Size.X), 0.01) + c * c / Math.Max(Math.Min(Size.X, Size.Y), 0.01);
        }

        internal double Middle { get { return double.IsNaN(Size.X) ? double.PositiveInfinity : Math.Max(Math.Min(Size.X, Size.Y), Math.Min(Math.Max(Size.X, Size.Y), Size.Z)); } }

        internal Vector Turned(Vector v) { return X * v.X + Y * v.Y + Z * v.Z; }
        public Vector ToWorld(Vector local) { return Place + Turned(local); }
        public Vector ToLocal(Vector world)
        {
            var from = world - Place;
            return new Vector(from.Dot(X), from.Dot(Y), from.Dot(Z));
        }
    }

    /// <summary>A signal as rows of samples, each heard with a mix of the gains of the lanes.</summary>
    public sealed class Signal
    {
        public float[][] Rows;
        public bool Loops;
        internal int Lane;
        internal double[][] Mix, Power;

        public Signal(float[] samples, bool loops) : this()
        {
            Rows = new[] { samples };
            Loops = loops;
            Mix = Power = new[] { new[] { 1.0 } };
        }

        internal Signal() { }

        /// <summary>A tone of whole hertz, endless, or fading within some seconds.</summary>
        public static Signal Tone(int frequency, double decay = double.PositiveInfinity, int rate = 8000)
        {
            var endless = double.IsPositiveInfinity(decay);
            var samples = new float[endless ? rate : (int)(8 * decay * rate)];
            for (var i = 0; i < samples.Length; i++)
                samples[i] = (float)(Math.Sin(2 * Math.PI * frequency * i / rate) * Math.Exp(-i / (decay * rate)));
            return new Signal(samples, endless);
        }

        /// <summary>The gain of the whole signal by the gains of the lanes from a place in them on.</summary>
        internal double Gain(double[] gains, int from)
        {
            var sum = 0.0;
            for (var i = 0; i < Power.Length; i++)
                for (var j = 0; j < Power.Length; j++)
                    sum += gains[from + i] * Power[i][j] * gains[from + j];
            return Math.Sqrt(Math.Max(sum, 0));
        }
    }

    /// <summary>What vibrates: always, or, where it plays once, whenever it is asked to.</summary>
    public sealed class Source
    {
        public string Name = "";
        /// <summary>The number of its object, and its position there.</summary>
        public int On;
        public Vector Position;
        public double Amplitude = 1;
        public bool Once;
        public Signal Signal;
        /// <summary>By listener: the numbers of the objects on the best path, from here on.</summary>
        public List<int>[] Paths = new List<int>[0];
        internal int Second = -1, Voices, Node, SecondNode;
        internal Vector SecondPosition;
        internal bool Started, Began;
        // By listener: gains of lanes, and before and now those of rows with all factors, and delays in samples.
        internal double[] Gains, Before, Now, Late, Later;

        internal bool Sounds { get { return Amplitude > 0 && Voices > 0; } }

        /// <summary>The gain of its signal on the best path to a listener.</summary>
        public double Gain(int listener)
        {
            return Gains == null ? 0 : Signal.Gain(Gains, listener * (Gains.Length / Paths.Length));
        }

        internal void Fit(int listeners, int lanes)
        {
            if (Paths.Length == listeners && Gains != null && Gains.Length == listeners * lanes && Now.Length == listeners * Signal.Rows.Length) return;
            Paths = new List<int>[listeners];
            for (var l = 0; l < listeners; l++) Paths[l] = new List<int>();
            Gains = new double[listeners * lanes];
            Now = new double[listeners * Signal.Rows.Length];
            Before = new double[Now.Length];
            Late = new double[listeners];
            Later = new double[listeners];
        }
    }

    /// <summary>Where it is felt: a ball on an object.</summary>
    public sealed class Listener
    {
        public string Name = "", BodyPart = "";
        public int On;
        public Vector Position;
        public double Radius, Gain = 1, SMax = 1;
        /// <summary>The samples of the last step; there may be room for more behind them.</summary>
        public float[] Samples = new float[0];
        internal float[] Recent;
        internal double Sum, Energy;
        internal int Node;
    }

    /// <summary>What a blow plays, by its strength.</summary>
    public sealed class Impact
    {
        public double LeastEnergy, FullEnergy = 100, WeakGain, FullGain = 1;
        public Signal[] Signals;
    }

    /// <summary>Two objects that touch. What is not known is left as it is: no area is a point.</summary>
    public sealed class Contact
    {
        public Vector At, OtherAt, Normal;
        public double Area, Depth, Force = double.NaN, Weight = 1;
        internal int One, Other, Number, Node, OtherNode;
        internal Function Function;
        internal bool Stays;
        // Of one that stays: in the spaces of the objects.
        internal Vector Near, OtherNear, NormalNear;
    }

    struct Voice
    {
        internal Source Source;
        internal int Place;
    }

    /// <summary>The tracer. Tell what moves, touches and hits, then step; then listeners have samples and levels.</summary>
    public sealed class Tracer
    {
        /// <summary>The cost at which a search ends: -120 dB.</summary>
        const double Limit = 13.815510557964274;
        const int Bands = 6, Chain = 4, MostBlows = 32;
        const double Infinite = double.PositiveInfinity;

        public readonly int Lanes, SampleRate;
        public readonly List<TracedObject> Objects = new List<TracedObject>();
        public readonly List<Source> Sources = new List<Source>();
        public readonly List<Listener> Listeners = new List<Listener>();
        /// <summary>The blows that sound; the last ones have begun last.</summary>
        public readonly List<Source> Blows = new List<Source>();
        /// <summary>By the classes of two objects: what contacts pass on, and what blows play.</summary>
        public Function[][] Between;
        public Impact[][] Impacts;
        /// <summary>The number of samples of the last step.</summary>
        public int Count { get; private set; }

        readonly List<Contact> contacts = new List<Contact>();
        readonly Stack<Contact> spare = new Stack<Contact>();
        readonly Stack<Source> spareBlows = new Stack<Source>();
        readonly HashSet<long> staying = new HashSet<long>();
        readonly List<Voice> voices = new List<Voice>();
        readonly double[] omega = new double[Bands], costs;
        int recentPlace, recentCount;
        double part;
        bool isSpecial;

        // Nodes, sorted by object.
        TracedObject[] on = new TracedObject[0];
        int[] start = new int[1], owner = new int[0], partner, entry;
        double[] x, y, z, reach, run, half, arrival;
        bool[] settled, listens;
        Contact[] contact;
        // Of leaving over the contact of a node: by lane the cost, NaN if it is not known yet; whether it is by bodies, and by what
        // stands behind these; by band their mobilities alone, and as they carry others. Of the contact 1 / weight and 1 / stiffness,
        // and the square of its distance beside the body's middle.
        readonly double[][] crossing, own = new double[Bands][], mobility = new double[Bands][];
        bool[] byBodies, carried;
        double[] opening, compliance, aside, flexible, across, round;
        // A heap of entries.
        double[] keys = new double[64];
        int[] values = new int[64];
        int size;

        public Tracer(int lanes = 1, int sampleRate = 8000)
        {
            Lanes = lanes;
            SampleRate = sampleRate;
            costs = new double[lanes];
            crossing = new double[lanes][];
            Between = new[] { new[] { new Function(0, 0, lanes) } };
            Impacts = new[] { new[] { new Impact { LeastEnergy = 0.05, Signals = new[] { Signal.Tone(150, 0.03, sampleRate) } } } };
        }

        /// <summary>Two objects touch, until they part. Keep the contact up to date; null if the file says where they touch.</summary>
        public Contact Touch(int one, int other)
        {
            if (staying.Contains(Key(one, other))) return null;
            var added = spare.Count > 0 ? spare.Pop() : new Contact();
            added.One = one;
            added.Other = other;
            added.Function = Between[Objects[one].Class][Objects[other].Class];
            added.Number = contacts.Count;
            contacts.Add(added);
            return added;
        }

        /// <summary>Two objects touch no more.</summary>
        public void Part(Contact parted)
        {
            var last = contacts[contacts.Count - 1];
            contacts[last.Number = parted.Number] = last;
            contacts.RemoveAt(contacts.Count - 1);
            spare.Push(parted);
        }

        /// <summary>The energy in joules of a blow at a speed along the normal.</summary>
        public double Energy(int one, int other, double speed)
        {
            double a = Objects[one].Mass, b = Objects[other].Mass;
            var inverse = (a > 0 ? 1 / a : 0) + (b > 0 ? 1 / b : 0);
            return inverse > 0 ? speed * speed / (2 * inverse) : 0;
        }

        /// <summary>Two objects hit each other, some seconds after the next step's beginning. Whether it sounds: the blow is the last of Blows then.</summary>
        public bool Blow(int one, int other, Vector at, double energy, double after = 0)
        {
            var impact = Impacts[Objects[one].Class][Objects[other].Class];
            if (impact == null || energy < impact.LeastEnergy) return false;
            var strength = Math.Min(energy / impact.FullEnergy, 1);
            if (Blows.Count == MostBlows) End(Blows[0]);
            var blow = spareBlows.Count > 0 ? spareBlows.Pop() : new Source { Once = true };
            blow.Signal = impact.Signals[(int)Math.Round(strength * (impact.Signals.Length - 1))];
            blow.Amplitude = impact.WeakGain + (impact.FullGain - impact.WeakGain) * strength;
            blow.On = one;
            blow.Second = other;
            blow.Position = Objects[one].ToLocal(at);
            blow.SecondPosition = Objects[other].ToLocal(at);
            Blows.Add(blow);
            Play(blow, after);
            return true;
        }

        /// <summary>Play the signal of a source, some seconds after the next step's beginning.</summary>
        public void Play(Source source, double after = 0)
        {
            source.Began = source.Voices++ == 0;
            voices.Add(new Voice { Source = source, Place = -(int)Math.Round(after * SampleRate) });
        }

        /// <summary>Go on by some seconds.</summary>
        public void Step(double seconds)
        {
            part += seconds * SampleRate;
            Count = (int)Math.Floor(part + 0.5);
            part -= Count;
            isSpecial = false;
            foreach (var item in Objects) isSpecial |= item.Function.IsSpecial;
            foreach (var source in Sources)
                if (!source.Once && !source.Started)
                {
                    source.Started = true;
                    Play(source);
                }
            Number();
            PassOn();
            foreach (var source in Sources) Propagate(source);
            foreach (var blow in Blows) Propagate(blow);
            Mix();
        }

        /// <summary>The level of the last quarter second of a listener in decibels, NaN for silence.</summary>
        public double Level(int listener)
        {
            var felt = Listeners[listener];
            var energy = felt.Energy - felt.Sum * felt.Sum / (SampleRate / 4);
            return energy > 1e-10 * recentCount ? 10 * Math.Log10(energy / recentCount) : double.NaN;
        }

        static long Key(int one, int other) { return (long)Math.Min(one, other) << 32 | (uint)Math.Max(one, other); }

        void End(Source blow)
        {
            for (var i = voices.Count - 1; i >= 0; i--) if (voices[i].Source == blow) voices.RemoveAt(i);
            blow.Voices = 0;
            Blows.Remove(blow);
            spareBlows.Push(blow);
        }

        // The graph.

        void Number()
        {
            if (on.Length != Objects.Count) on = new TracedObject[Objects.Count];
            Objects.CopyTo(on);
            if (start.Length != Objects.Count + 1) start = new int[Objects.Count + 1];
            Array.Clear(start, 0, start.Length);
            foreach (var touching in contacts)
            {
                if (touching.Stays)
                {
                    touching.At = Objects[touching.One].ToWorld(touching.Near);
                    touching.OtherAt = Objects[touching.Other].ToWorld(touching.OtherNear);
                    touching.Normal = Objects[touching.One].Turned(touching.NormalNear);
                }
                start[touching.One]++;
                start[touching.Other]++;
            }
            for (var i = 0; i < Objects.Count; i++) Objects[i].Carries = start[i] > 1 && Objects[i].Body != null && Objects[i].Body.Carries;
            foreach (var source in Sources) start[source.On]++;
            foreach (var blow in Blows)
            {
                start[blow.On]++;
                start[blow.Second]++;
            }
            foreach (var listener in Listeners) start[listener.On]++;
            for (var i = 1; i < start.Length; i++) start[i] += start[i - 1];
            Room(start[Objects.Count]);
            // Filled from the end of each object's nodes, so that its start is what is left.
            foreach (var touching in contacts)
            {
                touching.Node = Node(touching.One, touching.At, touching);
                touching.OtherNode = Node(touching.Other, touching.OtherAt, touching);
                partner[touching.Node] = touching.OtherNode;
                partner[touching.OtherNode] = touching.Node;
                Front(touching);
            }
            foreach (var source in Sources) source.Node = source.SecondNode = Node(source.On, Objects[source.On].ToWorld(source.Position));
            foreach (var blow in Blows)
            {
                blow.Node = Node(blow.On, Objects[blow.On].ToWorld(blow.Position));
                blow.SecondNode = Node(blow.Second, Objects[blow.Second].ToWorld(blow.SecondPosition));
            }
            foreach (var listener in Listeners)
            {
                listener.Node = Node(listener.On, Objects[listener.On].ToWorld(listener.Position));
                reach[listener.Node] = listener.Radius;
                listens[listener.Node] = true;
            }
        }

        void Room(int count)
        {
            if (owner.Length >= count) return;
            count += count / 2;
            owner = new int[count];
            partner = new int[count];
            entry = new int[count];
            x = new double[count];
            y = new double[count];
            z = new double[count];
            reach = new double[count];
            run = new double[count];
            half = new double[count];
            arrival = new double[count];
            settled = new bool[count];
            listens = new bool[count];
            contact = new Contact[count];
            byBodies = new bool[count];
            carried = new bool[count];
            opening = new double[count];
            compliance = new double[count];
            aside = new double[count];
            flexible = new double[count];
            across = new double[count];
            round = new double[count];
            for (var lane = 0; lane < Lanes; lane++) crossing[lane] = new double[count];
            for (var band = 0; band < Bands; band++)
            {
                own[band] = new double[count];
                mobility[band] = new double[count];
            }
        }

        int Node(int number, Vector at, Contact of = null)
        {
            var node = --start[number];
            owner[node] = number;
            partner[node] = -1;
            contact[node] = of;
            x[node] = at.X;
            y[node] = at.Y;
            z[node] = at.Z;
            reach[node] = run[node] = half[node] = 0;
            listens[node] = false;
            return node;
        }

        /// <summary>The fronts of waves that begin with the size of a patch.</summary>
        void Front(Contact touching)
        {
            if (touching.Area == 0) return;
            TracedObject one = Objects[touching.One], other = Objects[touching.Other];
            var wide = Math.Max(one.Across(touching.Normal), other.Across(touching.Normal));
            var patch = Math.Min(Math.Max(Math.Sqrt(touching.Area), touching.Area * wide), 2 * Math.Min(one.Middle, other.Middle));
            Front(touching.Node, one.Function, patch);
            Front(touching.OtherNode, other.Function, patch);
        }

        void Front(int node, Function function, double patch)
        {
            run[node] = Math.Max(patch - function.Point, 0);
            if (run[node] > 0) half[node] = function.Spread(run[node]) / 2;
        }

        // What contacts pass on by the impedances of their bodies.

        void PassOn()
        {
            var count = start[on.Length];
            foreach (var row in crossing) for (var node = 0; node < count; node++) row[node] = double.NaN;
            for (var node = 0; node < count && Lanes > 1; node++)
            {
                var body = on[owner[node]].Body;
                if (contact[node] == null) continue;
                for (var band = 0; band < Bands; band++)
                    own[band][node] = body == null ? 0 : body.HalfSpace == null ? body.Mobility[band] : body.At(omega[band], contact[node].Area);
            }
            var isCarried = false;
            for (var node = 0; node < count; node++)
            {
                byBodies[node] = carried[node] = false;
                if (Lanes == 1 || contact[node] == null) continue;
                TracedObject item = on[owner[node]], over = on[owner[partner[node]]];
                var spring = contact[node].Function.Spring;
                opening[node] = 1 / Math.Max(contact[node].Weight, 1e-12);
                compliance[node] = spring == null ? 0 : 1 / spring[0];
                byBodies[node] = spring != null && item.Body != null && over.Body != null && (item.Body.Kind != over.Body.Kind || spring[0] < Infinite);
                if (!byBodies[node] || !item.Carries) continue;
                // What is heavier than its load in all bands passes everything anyway.
                var isLight = IsSoft(node);
                for (var band = 0; band < Bands; band++) isLight |= own[band][node] > own[band][partner[node]];
                carried[node] = isLight;
                isCarried |= isLight;
            }
            if (!isCarried) return;
            for (var o = 0; o < on.Length; o++)
            {
                if (!on[o].Carries) continue;
                var middle = on[o].ToWorld(on[o].Centre);
                for (int node = start[o], end = start[o + 1]; node < end; node++)
                {
                    if (contact[node] == null) continue;
                    var n = contact[node].Normal;
                    double dx = x[node] - middle.X, dy = y[node] - middle.Y, dz = z[node] - middle.Z;
                    double a = dy * n.Z - dz * n.Y, b = dz * n.X - dx * n.Z, c = dx * n.Y - dy * n.X;
                    aside[node] = double.IsNaN(dx) ? Infinite : Math.Max(a * a + b * b + c * c, 1e-12);
                }
            }
            for (var band = 0; band < Bands; band++) Carry(band);
        }

        bool IsSoft(int node) { return compliance[node] > 0 || on[owner[node]].Body.Spring != null; }

        /// <summary>The mobilities in a band with which small bodies drive others: those of what stands behind them, through some in a row.</summary>
        void Carry(int band)
        {
            double[] before = round, now = mobility[band], alone = own[band], open = opening, away = flexible, over = across;
            var other = partner;
            for (var o = 0; o < on.Length; o++)
            {
                on[o].Due = 1;
                var spring = on[o].Carries ? on[o].Body.Spring : null;
                for (int node = start[o], end = start[o + 1]; node < end; node++)
                {
                    before[node] = now[node] = spring == null ? alone[node] : Infinite;
                    if (!on[o].Carries) continue;
                    away[node] = spring == null ? aside[node] / on[o].Body.Bending[band] : omega[band] / (2 * spring[0]);
                    over[node] = away[node] + omega[band] * compliance[node];
                }
            }
            for (var link = 0; link < Chain; link++)
            {
                var swapped = before;
                before = now;
                now = swapped;
                for (var o = 0; o < on.Length; o++)
                {
                    int first = start[o], end = start[o + 1], least = -1;
                    var item = on[o];
                    if (!item.Carries) continue;
                    if ((item.Due >> link & 1) == 0)
                    {
                        for (var node = first; node < end; node++) now[node] = before[node];
                        continue;
                    }
                    double best = Infinite, second = Infinite;
                    for (var node = first; node < end; node++)
                    {
                        var beyond = other[node];
                        if (beyond < 0) continue;
                        var behind = open[node] * (before[beyond] + over[node]);
                        if (behind >= second) continue;
                        second = behind < best ? best : behind;
                        if (behind >= best) continue;
                        best = behind;
                        least = node;
                    }
                    var isSpring = item.Body.Spring != null;
                    for (var node = first; node < end; node++)
                    {
                        var driving = away[node] + (node == least ? second : best);
                        if (!isSpring && driving > alone[node]) driving = alone[node];
                        now[node] = driving;
                        if (driving != before[node] && other[node] >= 0) on[owner[other[node]]].Due |= 2 << link;
                    }
                }
            }
        }

        /// <summary>The gain of leaving through a node by the impedances of the bodies.</summary>
        double Passed(int node, int band)
        {
            double load = own[band][partner[node]], driving = carried[node] ? mobility[band][node] : own[band][node];
            if (!IsSoft(node)) return Math.Min(2 / (1 + driving / load), 1);
            var loss = compliance[node] > 0 ? contact[node].Function.Spring[1] : on[owner[node]].Body.Spring[1];
            double above = Math.Max((driving + omega[band] * compliance[node]) / load, 2) - 1, square = loss * loss;
            return Math.Sqrt((1 + square) / (above * above + square));
        }

        /// <summary>The cost of leaving an object through a node.</summary>
        double Crossing(int node, int lane)
        {
            var known = crossing[lane][node];
            if (!double.IsNaN(known)) return known;
            var touching = contact[node];
            var function = touching.Function;
            int from = touching.Node, to = touching.OtherNode;
            double cost = function.Loss[lane], distance = x[from] == x[to] && y[from] == y[to] && z[from] == z[to] ? 0 : Distance(from, to);
            if (distance > 0 || function.IsSpecial) cost += function.Decay[lane] * distance + function.Shape(distance, Value(touching, distance), 0, 0, 0);
            if (touching.Weight < 1) cost -= Math.Log(touching.Weight);
            if (byBodies[node])
            {
                var gain = lane > 0 ? Passed(node, lane - 1) : 0;
                for (var band = 0; band < Bands && lane == 0; band++) gain = Math.Max(gain, Passed(node, band));
                cost -= Math.Log(gain);
            }
            return crossing[lane][node] = cost;
        }

        static double Value(Contact touching, double distance)
        {
            switch (touching.Function.Variable)
            {
                case "area": return touching.Area;
                case "depth": return touching.Depth;
                case "force": return touching.Force;
                case "angle": return Math.Acos(Math.Min(Math.Abs(touching.Normal.Y), 1));
            }
            return distance;
        }

        // Best paths.

        void Propagate(Source source)
        {
            source.Fit(Listeners.Count, Lanes);
            Array.Clear(source.Gains, 0, source.Gains.Length);
            foreach (var path in source.Paths) path.Clear();
            var before = source.Before;
            source.Before = source.Now;
            source.Now = before;
            before = source.Late;
            source.Late = source.Later;
            source.Later = before;
            if (source.Sounds && Listeners.Count > 0)
            {
                Search(source, source.Signal.Lane);
                if (!Collect(source) && source.Signal.Lane > 0)
                {
                    Search(source, 0);
                    Collect(source);
                }
            }
            var rows = source.Signal.Rows.Length;
            for (var l = 0; l < Listeners.Count; l++)
                for (var row = 0; row < rows; row++)
                {
                    var mix = source.Signal.Mix[row];
                    var gain = 0.0;
                    for (var lane = 0; lane < mix.Length; lane++) gain += mix[lane] * source.Gains[l * Lanes + lane];
                    source.Now[l * rows + row] = gain * source.Amplitude * Listeners[l].Gain;
                }
            if (!source.Began) return;
            source.Began = false;
            Array.Copy(source.Now, source.Before, source.Now.Length);
            Array.Copy(source.Later, source.Late, source.Later.Length);
        }

        double Distance(int a, int b)
        {
            double u = x[a] - x[b], v = y[a] - y[b], w = z[a] - z[b];
            return Math.Max(Math.Sqrt(u * u + v * v + w * w) - reach[a] - reach[b], 0);
        }

        /// <summary>Dijkstra's algorithm; one step is through an object and over a contact.</summary>
        void Search(Source source, int lane)
        {
            var count = start[Objects.Count];
            for (var node = 0; node < count; node++)
            {
                arrival[node] = Limit * (1 + 1e-15);
                entry[node] = -1;
                settled[node] = false;
            }
            var limit = Limit;
            size = 0;
            Push(0, source.Node);
            if (source.SecondNode != source.Node) Push(0, source.SecondNode);
            double[] leaving = crossing[lane], u = x, v = y, w = z, to = arrival, fronts = run, halves = half, balls = reach;
            while (size > 0 && keys[0] <= limit)
            {
                var near = keys[0];
                var begin = values[0];
                Pop();
                var number = owner[begin];
                var function = on[number].Function;
                near += function.Loss[lane];
                if (settled[begin] || to[begin] <= near && !isSpecial) continue;
                settled[begin] = true;
                double decay = function.Decay[lane], x0 = u[begin], y0 = v[begin], z0 = w[begin], ball = balls[begin];
                var isNearer = false;
                for (int end = start[number], last = start[number + 1]; end < last; end++)
                {
                    if (end == begin || to[end] <= near) continue;
                    double dx = u[end] - x0, dy = v[end] - y0, dz = w[end] - z0;
                    var distance = Math.Max(Math.Sqrt(dx * dx + dy * dy + dz * dz) - ball - balls[end], 0);
                    var far = near + decay * distance;
                    if (far >= to[end]) continue;
                    far += function.Shape(distance, distance, fronts[begin], fronts[end], halves[begin] + halves[end]);
                    if (far >= to[end]) continue;
                    to[end] = far;
                    entry[end] = begin;
                    isNearer |= listens[end];
                    var over = partner[end];
                    if (over < 0) continue;
                    far += double.IsNaN(leaving[end]) ? Crossing(end, lane) : leaving[end];
                    if (far <= limit && (isSpecial || far + on[owner[over]].Function.Loss[lane] < to[over])) Push(far, over);
                }
                if (!isNearer) continue;
                var dearest = 0.0;
                foreach (var listener in Listeners) dearest = Math.Max(dearest, to[listener.Node]);
                limit = Math.Min(limit, dearest);
            }
        }

        /// <summary>Take gains and paths to the listeners without any from the last search. Whether all have one then.</summary>
        bool Collect(Source source)
        {
            var all = true;
            for (var l = 0; l < Listeners.Count; l++)
            {
                var path = source.Paths[l];
                var node = Listeners[l].Node;
                if (path.Count > 0) continue;
                if (entry[node] < 0)
                {
                    all = false;
                    continue;
                }
                Array.Clear(costs, 0, Lanes);
                var late = 0.0;
                while (true)
                {
                    var begin = entry[node];
                    var function = Objects[owner[node]].Function;
                    var distance = Distance(begin, node);
                    var shape = function.Shape(distance, distance, run[begin], run[node], half[begin] + half[node]);
                    for (var lane = 0; lane < Lanes; lane++) costs[lane] += function.Loss[lane] + function.Decay[lane] * distance + shape;
                    late += function.Slowness * distance;
                    if (path.Count == 0 || path[path.Count - 1] != owner[node]) path.Add(owner[node]);
                    node = partner[begin];
                    if (node < 0) break;
                    var touching = contact[begin];
                    for (var lane = 0; lane < Lanes; lane++) costs[lane] += Crossing(node, lane);
                    late += touching.Function.Slowness * (touching.At - touching.OtherAt).Length;
                }
                path.Reverse();
                for (var lane = 0; lane < Lanes; lane++) source.Gains[l * Lanes + lane] = Math.Exp(-costs[lane]);
                source.Later[l] = late * SampleRate;
            }
            return all;
        }

        void Push(double key, int value)
        {
            if (size == keys.Length)
            {
                Array.Resize(ref keys, 2 * size);
                Array.Resize(ref values, 2 * size);
            }
            var costs = keys;
            var nodes = values;
            var place = size++;
            for (int above; place > 0 && costs[above = (place - 1) >> 1] > key; place = above)
            {
                costs[place] = costs[above];
                nodes[place] = nodes[above];
            }
            costs[place] = key;
            nodes[place] = value;
        }

        void Pop()
        {
            var costs = keys;
            var nodes = values;
            var key = costs[--size];
            int place = 0, count = size;
            for (int below; (below = 2 * place + 1) < count; place = below)
            {
                if (below + 1 < count && costs[below + 1] < costs[below]) below++;
                if (costs[below] >= key) break;
                costs[place] = costs[below];
                nodes[place] = nodes[below];
            }
            costs[place] = key;
            nodes[place] = nodes[count];
        }

        // Samples.

        void Mix()
        {
            var window = SampleRate / 4;
            foreach (var listener in Listeners)
            {
                if (listener.Samples.Length < Count) listener.Samples = new float[Count];
                if (listener.Recent == null) listener.Recent = new float[window];
                Array.Clear(listener.Samples, 0, Count);
            }
            for (var i = voices.Count - 1; i >= 0; i--)
            {
                var voice = voices[i];
                var longest = 0.0;
                for (var l = 0; l < Listeners.Count; l++)
                {
                    Hear(voice, l);
                    longest = Math.Max(longest, voice.Source.Later[l]);
                }
                var signal = voice.Source.Signal;
                var length = signal.Rows[0].Length;
                voice.Place += Count;
                if (signal.Loops) voice.Place = voice.Place < 2 * length + longest ? voice.Place : voice.Place - length;
                voices[i] = voice;
                if (signal.Loops || voice.Place < length + longest) continue;
                voices.RemoveAt(i);
                voice.Source.Voices--;
            }
            for (var i = Blows.Count - 1; i >= 0; i--) if (Blows[i].Voices == 0) End(Blows[i]);
            foreach (var felt in Listeners)
            {
                var samples = felt.Samples;
                var most = (float)felt.SMax;
                for (var i = 0; i < Count; i++)
                {
                    var place = (recentPlace + i) % window;
                    double sample = Math.Max(-most, Math.Min(samples[i], most)), old = felt.Recent[place];
                    samples[i] = felt.Recent[place] = (float)sample;
                    felt.Sum += sample - old;
                    felt.Energy += sample * sample - old * old;
                }
            }
            recentPlace = (recentPlace + Count) % window;
            recentCount = Math.Min(recentCount + Count, window);
        }

        /// <summary>Add a voice to the samples of a listener; its gains go in straight lines over the step.</summary>
        void Hear(Voice voice, int number)
        {
            var source = voice.Source;
            var rows = source.Signal.Rows;
            var samples = Listeners[number].Samples;
            double late = source.Late[number], later = source.Later[number];
            for (var r = 0; r < rows.Length; r++)
            {
                var place = number * rows.Length + r;
                var gain = (float)source.Before[place];
                var slope = ((float)source.Now[place] - gain) / Math.Max(Count, 1);
                if (gain == 0 && slope == 0) continue;
                var row = rows[r];
                if (late > 0 || later > 0)
                {
                    for (var i = 0; i < Count; i++)
                    {
                        var at = voice.Place + i - late - (later - late) * i / Count;
                        var whole = (int)Math.Floor(at);
                        var share = (float)(at - whole);
                        samples[i] += (gain + slope * i) * ((1 - share) * Sample(source.Signal, row, whole) + share * Sample(source.Signal, row, whole + 1));
                    }
                    continue;
                }
                for (int i = Math.Max(-voice.Place, 0), from = Math.Max(voice.Place, 0); i < Count; from = 0)
                {
                    if (source.Signal.Loops) from %= row.Length;
                    var stop = Math.Min(Count, i + row.Length - from);
                    for (from -= i; i < stop; i++) samples[i] += (gain + slope * i) * row[from + i];
                    if (!source.Signal.Loops) break;
                }
            }
        }

        static float Sample(Signal signal, float[] row, int place)
        {
            if (place < 0) return 0;
            return signal.Loops ? row[place % row.Length] : place < row.Length ? row[place] : 0;
        }

        // The file.

        /// <summary>A tracer of the tables in NAME.tracer.json.</summary>
        public static Tracer Read(string json)
        {
            var file = (Dictionary<string, object>)Json.Read(json);
            if ((string)file["format"] != "haptic-tracer" || (double)file["version"] != 1) throw new FormatException("no tables of a haptic tracer 1");
            var tracer = new Tracer(Whole(file["lanes"]), Whole(file["sample_rate"]));
            var frequencies = Numbers(file["frequencies"]);
            for (var band = 0; band < Bands; band++) tracer.omega[band] = 2 * Math.PI * frequencies[band];
            var grid = Numbers(file["grid"]);
            var functions = List(file["functions"]).ConvertAll(row => ReadFunction(row, grid));
            var signals = List(file["signals"]).ConvertAll(ReadSignal);
            var impacts = List(file["impacts"]).ConvertAll(row => ReadImpact(row, signals));
            tracer.Between = Table(file["between"], functions);
            tracer.Impacts = Table(file["blows"], impacts);
            foreach (Dictionary<string, object> row in List(file["objects"]))
            {
                var pose = Numbers(row["pose"]);
                var item = new TracedObject { Name = (string)row["name"], Class = Whole(row["class"]), Mass = (double)row["mass"], Function = functions[Whole(row["function"])] };
                item.Move(pose[0], pose[1], pose[2], pose[3], pose[4], pose[5], pose[6]);
                if (row.ContainsKey("centre"))
                {
                    item.Centre = Vector(row["centre"]);
                    item.Size = Vector(row["size"]);
                }
                if (row.ContainsKey("body"))
                {
                    var body = (Dictionary<string, object>)row["body"];
                    item.Body = new Body { Kind = Whole(body["kind"]), Mobility = Array.ConvertAll(Numbers(body["impedance"]), value => 1 / value), Bending = Numbers(Get(body, "bending")), HalfSpace = Numbers(Get(body, "half_space")), Spring = Numbers(Get(body, "spring")) };
                }
                tracer.Objects.Add(item);
            }
            foreach (Dictionary<string, object> row in List(file["contacts"]))
            {
                List<object> objects = List(row["objects"]), places = List(row["positions"]);
                var added = new Contact { One = Whole(objects[0]), Other = Whole(objects[1]), Near = Vector(places[0]), OtherNear = Vector(places[1]), NormalNear = Vector(row["normal"]), Area = (double)row["area"], Depth = (double)row["depth"], Weight = (double)row["weight"], Function = functions[Whole(row["function"])], Stays = true };
                tracer.contacts.Add(added);
                tracer.staying.Add(Key(added.One, added.Other));
            }
            foreach (Dictionary<string, object> row in List(file["sources"]))
                tracer.Sources.Add(new Source { Name = (string)row["name"], On = Whole(row["object"]), Position = Vector(row["position"]), Amplitude = (double)row["amplitude"], Once = (bool)row["once"], Signal = signals[Whole(row["signal"])] });
            foreach (Dictionary<string, object> row in List(file["listeners"]))
                tracer.Listeners.Add(new Listener { Name = (string)row["name"], BodyPart = (string)row["body_part"], On = Whole(row["object"]), Position = Vector(row["position"]), Radius = (double)row["radius"], Gain = (double)row["gain"], SMax = (double)row["s_max"] });
            return tracer;
        }

        static Function ReadFunction(object form, double[] grid)
        {
            var row = (Dictionary<string, object>)form;
            var function = new Function { Loss = Numbers(row["loss"]), Decay = Numbers(row["decay"]), Grid = grid, Costs = Numbers(Get(row, "costs")), Spring = Numbers(Get(row, "spring")), Variable = (string)Get(row, "over") };
            if (row.ContainsKey("range")) function.Range = (double)row["range"];
            if (row.ContainsKey("slowness")) function.Slowness = (double)row["slowness"];
            var law = Numbers(Get(row, "spreading"));
            if (law == null) return function;
            function.Exponent = law[0];
            function.Reference = law[1];
            function.Extent = law[2];
            function.Width = law[3];
            function.Over = law[4];
            function.Point = law[5];
            return function;
        }

        static Signal ReadSignal(object form)
        {
            var row = (Dictionary<string, object>)form;
            var peak = (double)row["peak"];
            return new Signal { Lane = Whole(row["lane"]), Loops = (bool)row["loops"], Mix = List(row["mix"]).ConvertAll(Numbers).ToArray(), Power = List(row["power"]).ConvertAll(Numbers).ToArray(), Rows = List(row["rows"]).ConvertAll(text => Samples((string)text, peak)).ToArray() };
        }

        static float[] Samples(string text, double peak)
        {
            var bytes = Convert.FromBase64String(text);
            var integers = new short[bytes.Length / 2];
            Buffer.BlockCopy(bytes, 0, integers, 0, 2 * integers.Length);
            return Array.ConvertAll(integers, value => (float)(value * peak / 32767));
        }

        static Impact ReadImpact(object form, List<Signal> signals)
        {
            var row = (Dictionary<string, object>)form;
            var gain = Numbers(row["gain"]);
            return new Impact { LeastEnergy = (double)row["least_energy"], FullEnergy = (double)row["full_energy"], WeakGain = gain[0], FullGain = gain[1], Signals = List(row["signals"]).ConvertAll(number => signals[Whole(number)]).ToArray() };
        }

        static T[][] Table<T>(object rows, List<T> items) where T : class
        {
            return List(rows).ConvertAll(row => List(row).ConvertAll(number => number == null ? null : items[Whole(number)]).ToArray()).ToArray();
        }

        static object Get(Dictionary<string, object> form, string key)
        {
            object value;
            return form.TryGetValue(key, out value) ? value : null;
        }

        static List<object> List(object value) { return (List<object>)value; }
        static int Whole(object value) { return (int)(double)value; }
        static double[] Numbers(object value) { return value == null ? null : List(value).ConvertAll(item => item == null ? Infinite : (double)item).ToArray(); }
        static Vector Vector(object value)
        {
            var numbers = Numbers(value);
            return new Vector(numbers[0], numbers[1], numbers[2]);
        }
    }

    /// <summary>JSON as dictionaries, lists, strings, doubles, booleans and null.</summary>
    static class Json
    {
        public static object Read(string text)
        {
            var place = 0;
            return Read(text, ref place);
        }

        static object Read(string text, ref int place)
        {
            Skip(text, ref place);
            var start = place;
            switch (text[place++])
            {
                case '{':
                    var members = new Dictionary<string, object>();
                    while (More(text, ref place, '}'))
                    {
                        var key = (string)Read(text, ref place);
                        Skip(text, ref place);
                        place++; // the colon
                        members[key] = Read(text, ref place);
                    }
                    return members;
                case '[':
                    var items = new List<object>();
                    while (More(text, ref place, ']')) items.Add(Read(text, ref place));
                    return items;
                case '"':
                    while (text[place] != '"') place += text[place] == '\\' ? 2 : 1;
                    return Unescaped(text.Substring(start + 1, place++ - start - 1));
                case 't': place += 3; return true;
                case 'f': place += 4; return false;
                case 'n': place += 3; return null;
            }
            while (place < text.Length && "+-.eE0123456789".IndexOf(text[place]) >= 0) place++;
            return double.Parse(text.Substring(start, place - start), CultureInfo.InvariantCulture);
        }

        static string Unescaped(string text)
        {
            if (text.IndexOf('\\') < 0) return text;
            var found = new StringBuilder();
            for (var i = 0; i < text.Length; i++)
            {
                var escaped = text[i] == '\\' ? "bfnrt".IndexOf(text[++i]) : -2;
                if (escaped >= -1 && text[i] == 'u')
                {
                    found.Append((char)Convert.ToInt32(text.Substring(i + 1, 4), 16));
                    i += 4;
                }
                else found.Append(escaped < 0 ? text[i] : "\b\f\n\r\t"[escaped]);
            }
            return found.ToString();
        }

        static bool More(string text, ref int place, char close)
        {
            Skip(text, ref place);
            if (text[place] == ',') { place++; Skip(text, ref place); }
            if (text[place] != close) return true;
            place++;
            return false;
        }

        static void Skip(string text, ref int place) { while (char.IsWhiteSpace(text[place])) place++; }
    }
}
